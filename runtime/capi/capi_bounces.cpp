// The part of penumbra.h that handles light that bounces.
#include "runtime/capi/capi_handles.h"

namespace penumbra {

static_assert(PENUMBRA_BOUNCED_STRIDE == kIndirectStride);

const IndirectView& indirectOf(const AssetView& view) {
    if (!view.has_model || !view.model.indirect)
        throw Unsupported(view.name + ": has no light that bounces (penumbra-fit indirect)");
    return *view.model.indirect;
}

}  // namespace penumbra

using namespace penumbra;

int penumbra_asset_bounces(const penumbra_asset* asset) {
    if (!asset || !asset->data->view.has_model || !asset->data->view.model.indirect) return 0;
    return asset->data->view.model.indirect->bounces;
}

penumbra_status penumbra_character_evaluate_bounced(const penumbra_character* character, size_t first_cluster,
                                                    size_t cluster_count, float* bounced, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        requirePointer(bounced, "bounced");
        indirectOf(character->asset->view);
        const Evaluator& evaluator = character->evaluator;
        requireRange("clusters", first_cluster, cluster_count, evaluator.clusterCount());
        for (std::size_t c = first_cluster; c < first_cluster + cluster_count; ++c)
            evaluator.evaluateIndirect(c, {bounced, evaluator.vertexCount() * kIndirectStride});
    });
}

penumbra_status penumbra_character_ambient_bounced(const penumbra_character* character, size_t first_vertex,
                                                   size_t vertex_count, const float* numbers, const float* bounced,
                                                   float* ambient_out, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        requirePointer(bounced, "bounced");
        const IndirectView& indirect = indirectOf(character->asset->view);
        if (const penumbra_status status =
                penumbra_character_ambient(character, first_vertex, vertex_count, numbers, ambient_out, error))
            throw UsageError(error ? error->message : "wrong arguments (status " + std::to_string(status) + ")");
        const std::size_t vertices = character->evaluator.vertexCount();
        addBouncedAmbient(indirect.axes, first_vertex, first_vertex + vertex_count,
                          {bounced, vertices * kIndirectStride}, {ambient_out, vertices});
    });
}

penumbra_status penumbra_shading_set_bounces(penumbra_shading* shading, penumbra_bounces bounces,
                                             penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        if (int(bounces) < 0 || int(bounces) > PENUMBRA_BOUNCED_LIGHT)
            throw UsageError("bounces is no penumbra_bounces");
        constexpr Bounces kShown[] = {Bounces::kBoth, Bounces::kDirect, Bounces::kIndirect};
        shading->set->setBounces(kShown[bounces]);
    });
}

penumbra_status penumbra_shading_shade_bounced(const penumbra_shading* shading, const float eye[3], size_t first,
                                               size_t count, const penumbra_vertices* vertices, const float* bounced,
                                               float* radiance, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        const Vec3 from = pointFrom("eye", eye);
        requirePointer(vertices, "vertices");
        requirePointer(vertices->positions, "vertices->positions");
        requirePointer(vertices->normals, "vertices->normals");
        requirePointer(vertices->tangents, "vertices->tangents");
        requirePointer(vertices->numbers, "vertices->numbers");
        requirePointer(radiance, "radiance");
        const std::size_t n = shading->view.mesh.positions.size();
        requireRange("vertices", first, count, n);
        if (bounced) indirectOf(shading->view);
        shading->set->shade(
            first, first + count, vectors(vertices->positions, n), vectors(vertices->normals, n),
            vectors(vertices->tangents, n), {vertices->numbers, n * std::size_t(shading->view.model.stride)}, from,
            vectors(radiance, n), bounced ? std::span(bounced, n * kIndirectStride) : std::span<const float>());
    });
}
