// The part of penumbra.h that casts characters on one another and on the engine's own meshes.
#include <algorithm>
#include <cmath>

#include "runtime/capi/capi_handles.h"
#include "runtime/cast/cast_on_cluster.h"
#include "runtime/shade/indirect_light.h"
#include "runtime/shade/shading.h"
#include "sh/sh_basis.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

constexpr int kTransferOrder = 5;
constexpr std::size_t kTransferNumbers = kTransferOrder * kTransferOrder;
constexpr std::size_t kMaxCasters = 65535;

void requireCaster(const penumbra_scene& scene, std::size_t except) {
    if (except != PENUMBRA_NONE) requireIndex("except", except, scene.evaluators.size());
}

CasterChoice allBut(std::size_t except) { return {.except = except == PENUMBRA_NONE ? kNobody : except}; }

// Up to kMaxReceivers points, and what they see.
struct CastBatch {
    std::array<Vec3, kMaxReceivers> positions, normals, tangents;
    std::array<float, kMaxReceivers * kFarNumbers> mirrored;

    std::size_t evaluate(const CastShadow& cast, CasterChoice choice, std::size_t count) {
        return cast.evaluate({{positions.data(), count}, {normals.data(), count}, {tangents.data(), count}}, choice,
                             {mirrored.data(), count * kFarNumbers});
    }
};

// 8 heights and 16 directions around are exact for what is integrated: V has 6 bands, the cosine 2 and y_i 5.
void integrateTransfer(const penumbra_scene& scene, const float* mirrored, Vec3 normal, Vec3 tangent, float* out) {
    const Vec3d n = toDouble(normal), t = toDouble(tangent), b = cross(n, t);
    std::array<double, kTransferNumbers> y, sum{};
    for (std::size_t d = 0; d < scene.directions.size(); ++d) {
        double v = 0;
        for (std::size_t i = 0; i < kFarNumbers; ++i) v += double(mirrored[i]) * double(scene.basis[d][i]);
        const Vec3d local = scene.directions[d].direction;
        evalBasis(kTransferOrder, t * local.x + b * local.y + n * local.z, y);
        const double weight = v * scene.directions[d].weight * local.z;
        for (std::size_t i = 0; i < kTransferNumbers; ++i) sum[i] += weight * y[i];
    }
    std::copy(sum.begin(), sum.end(), out);
}

}  // namespace

Affine rigidOf(const float* to_scene) {
    Affine out;
    if (!to_scene) return out;
    requireFinite("to_scene", {to_scene, 12});
    std::copy_n(to_scene, 12, out.m.begin());
    const Mat3 turn = out.linear();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            float product = 0;
            for (int k = 0; k < 3; ++k) product += turn(k, i) * turn(k, j);
            if (std::abs(product - float(i == j)) > 1e-3f)
                throw UsageError("to_scene is no rotation and translation: characters have one size");
        }
    return out;
}

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_scene_create(const penumbra_asset* const* assets, size_t caster_count, penumbra_scene** scene,
                                      penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        if (caster_count > 0) requirePointer(assets, "assets");
        if (caster_count > kMaxCasters)  // each has a part or a sphere
            throw Unsupported("the casters of a scene have more than 65535 parts or spheres");
        auto made = std::make_unique<penumbra_scene>();
        for (std::size_t i = 0; i < caster_count; ++i) {
            requirePointer(assets[i], "an asset");
            const std::shared_ptr<const AssetData>& data = assets[i]->data;
            if (!data->view.has_model || (!data->view.model.composition && data->view.blockers.spheres.empty()))
                throw Unsupported(data->view.name +
                                  ": has neither fields of parts nor spheres, so that it casts nothing");
            made->assets.push_back(data);
            made->evaluators.push_back(data->restPose());
        }
        std::vector<const Evaluator*> casters;
        for (const Evaluator& evaluator : made->evaluators) casters.push_back(&evaluator);
        try {
            made->cast.emplace(casters);
        } catch (const std::length_error& tooMany) {
            throw Unsupported(tooMany.what());
        }
        for (const Evaluator* one : casters) {
            const bool fields = casterKindOf(*one) == CasterKind::kFields;
            penumbra_caster& caster = made->casters.emplace_back();
            caster.kind = fields ? PENUMBRA_CASTS_FIELDS : PENUMBRA_CASTS_SPHERES;
            caster.hidden = 1;
            std::ranges::copy(Affine().m, caster.to_scene);
        }
        made->directions = gaussHemisphere(8, 16);
        std::vector<double> y(kFieldNumbers);
        const std::vector<int> even = evenIndices(kFieldOrder);
        for (const WeightedDirection& d : made->directions) {
            evalBasis(kFieldOrder, d.direction, y);
            std::array<float, kFarNumbers>& row = made->basis.emplace_back();
            for (std::size_t i = 0; i < row.size(); ++i) row[i] = float(y[std::size_t(even[i])]);
        }
        *scene = made.release();
    });
}

void penumbra_scene_destroy(penumbra_scene* scene) { delete scene; }

penumbra_status penumbra_scene_set_caster(penumbra_scene* scene, size_t caster, const penumbra_character* character,
                                          const float* to_scene, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        requireIndex("caster", caster, scene->evaluators.size());
        penumbra_caster& known = scene->casters[caster];
        if (!character) {
            known.hidden = 1;
            return scene->cast->hide(caster);
        }
        if (character->asset != scene->assets[caster])
            throw UsageError("the character is not of the asset of caster " + std::to_string(caster));
        const Affine placed = rigidOf(to_scene);
        known.hidden = 0;
        std::ranges::copy(placed.m, known.to_scene);
        scene->cast->pose(caster, character->evaluator.bones(), placed);
    });
}

size_t penumbra_scene_caster_count(const penumbra_scene* scene) { return scene ? scene->casters.size() : 0; }

penumbra_status penumbra_scene_get_caster(const penumbra_scene* scene, size_t caster, penumbra_caster* out,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        requirePointer(out, "out");
        requireIndex("caster", caster, scene->casters.size());
        *out = scene->casters[caster];
    });
}

size_t penumbra_asset_sphere_count(const penumbra_asset* asset) {
    return asset ? asset->data->view.blockers.spheres.size() : 0;
}

penumbra_status penumbra_character_get_spheres(const penumbra_character* character, const float* to_scene,
                                               float* spheres, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character");
        requirePointer(spheres, "spheres");
        const Affine placed = rigidOf(to_scene);
        const BlockersView& blockers = character->asset->view.blockers;
        for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
            const CasterSphere posed = movedBy(character->evaluator.bones()[blockers.joints[s]], blockers.spheres[s]);
            const Vec3 centre = placed.point(posed.centre);
            for (const float x : {centre.x, centre.y, centre.z, posed.radius}) *spheres++ = x;
        }
    });
}

penumbra_status penumbra_scene_probe(const penumbra_scene* scene, size_t except, const float* positions,
                                     const float* normals, size_t count, float* ambient_out, float* transfer,
                                     penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        requireCaster(*scene, except);
        if (count == 0) return;
        requireCount("count", count, kTransferNumbers * sizeof(float));
        requirePointer(positions, "positions");
        requirePointer(normals, "normals");
        requireFinite("positions", {positions, 3 * count});
        requireFinite("normals", {normals, 3 * count});
        std::array<float, kFarNumbers> weights;
        ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
        CastBatch batch;
        for (std::size_t first = 0; first < count; first += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, count - first);
            for (std::size_t i = 0; i < n; ++i) {
                batch.positions[i] = vectors(positions, count)[first + i];
                batch.normals[i] = vectors(normals, count)[first + i];
                batch.tangents[i] = tangentOf(batch.normals[i], {1, 0, 0});
            }
            batch.evaluate(*scene->cast, allBut(except), n);
            for (std::size_t i = 0; i < n; ++i) {
                const float* row = &batch.mirrored[i * kFarNumbers];
                float e = 0;
                for (std::size_t k = 0; k < kFarNumbers; ++k) e += weights[k] * row[k];
                if (ambient_out) ambient_out[first + i] = std::clamp(e, 0.0f, 1.0f);
                if (transfer)
                    integrateTransfer(*scene, row, batch.normals[i], batch.tangents[i],
                                      transfer + (first + i) * kTransferNumbers);
            }
        }
    });
}

penumbra_status penumbra_scene_cast(const penumbra_scene* scene, size_t except, const penumbra_character* character,
                                    const float* to_scene, size_t first_vertex, size_t vertex_count, float* numbers,
                                    penumbra_error* error) {
    return penumbra_scene_cast_bounced(scene, except, character, to_scene, first_vertex, vertex_count, numbers, nullptr,
                                       error);
}

penumbra_status penumbra_scene_cast_bounced(const penumbra_scene* scene, size_t except,
                                            const penumbra_character* character, const float* to_scene,
                                            size_t first_vertex, size_t vertex_count, float* numbers, float* bounced,
                                            penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        requirePointer(character, "character");
        requirePointer(numbers, "numbers");
        if (bounced) indirectOf(character->asset->view);
        requireCaster(*scene, except);
        if (character->asset->view.transfer)
            throw Unsupported(character->asset->view.name + ": nothing casts on transfer, which is no visibility");
        const Evaluator& evaluator = character->evaluator;
        requireRange("vertices", first_vertex, vertex_count, evaluator.vertexCount());
        const ModelView& model = character->asset->view.model;
        const Affine placed = rigidOf(to_scene);
        const Mat3 turn = placed.linear();
        const auto at = [&](std::size_t v) {
            Receiver vertex;
            evaluator.skin(v, {&vertex.position, 1}, {&vertex.normal, 1}, {&vertex.tangent, 1});
            return Receiver{placed.point(vertex.position), turn * vertex.normal, turn * vertex.tangent};
        };
        thread_local std::vector<float> mirrored;
        const std::size_t stride = std::size_t(model.stride), last_vertex = first_vertex + vertex_count;
        for (std::size_t c = 0; c < model.clusters.size(); ++c) {
            const std::size_t first = model.clusters[c].first_vertex;
            const std::size_t begin = std::max(first, first_vertex),
                              end = std::min(first + model.clusters[c].vertex_count, last_vertex);
            if (begin >= end) continue;
            mirrored.resize((end - begin) * kFarNumbers);
            if (castOnCluster(*scene->cast, allBut(except), evaluator, c, begin, end, at, mirrored) == 0) continue;
            character->product({numbers + begin * stride, (end - begin) * stride}, stride, mirrored);
            if (bounced) castOnIndirect(mirrored, {bounced + begin * kIndirectStride, (end - begin) * kIndirectStride});
        }
    });
}
