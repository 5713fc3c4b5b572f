// The part of penumbra.h that casts characters on one another and on the engine's own meshes.
#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/capi/capi_handles.h"
#include "runtime/cast/cast_on_cluster.h"
#include "runtime/cast/ground_shadow.h"
#include "runtime/shade/shading.h"
#include "sh/sh_basis.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxCasters = 65535;

void requireCaster(const penumbra_scene& scene, std::size_t except) {
    if (except != PENUMBRA_NONE) requireIndex("except", except, scene.evaluators.size());
}

CasterChoice allBut(std::size_t except) { return {.except = except == PENUMBRA_NONE ? kNobody : except}; }

// Calls body(i, mirrored, to_local) for each point, with what the casters leave visible there in its local frame.
template <class Body>
void overPoints(const penumbra_scene* scene, std::size_t except, const penumbra_points* points, std::size_t row,
                const Body& body) {
    requirePointer(scene, "scene");
    requireCaster(*scene, except);
    requirePointer(points, "points");
    const std::size_t count = points->count;
    if (count == 0) return;
    requireCount("count", count, std::max<std::size_t>(row, 3) * sizeof(float));
    requirePointer(points->positions, "positions", points->normals, "normals");
    requireFinite("positions", {points->positions, 3 * count});
    requireFinite("normals", {points->normals, 3 * count});
    const std::span<const Vec3> positions = vectors(points->positions, count),
                                normals = vectors(points->normals, count);
    std::array<Vec3, kMaxReceivers> tangents;
    std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
    for (std::size_t first = 0; first < count; first += kMaxReceivers) {
        const std::size_t n = std::min(kMaxReceivers, count - first);
        for (std::size_t i = 0; i < n; ++i) tangents[i] = tangentOf(normals[first + i], {1, 0, 0});
        scene->cast->evaluate({positions.subspan(first, n), normals.subspan(first, n), {tangents.data(), n}},
                              allBut(except), {mirrored.data(), n * kFarCoefficients});
        for (std::size_t i = 0; i < n; ++i)
            body(first + i, std::span<const float>(mirrored).subspan(i * kFarCoefficients, kFarCoefficients),
                 toLocalFrame(normals[first + i], tangents[i]));
    }
}

}  // namespace

std::size_t requireTransferOrder(int order) {
    constexpr int kMax = VisibilityTransfer::kMaxTransferOrder;
    if (order < 1 || order > kMax)
        throw UsageError("order is " + std::to_string(order) + ", allowed are 1.." + std::to_string(kMax));
    return std::size_t(coefficientCount(order));
}

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
        requirePointer(scene, "scene", out, "out");
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
        requirePointer(character, "character", spheres, "spheres");
        const Affine placed = rigidOf(to_scene);
        const BlockersView& blockers = character->asset->view.blockers;
        for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
            const CasterSphere posed = movedBy(character->evaluator.bones()[blockers.joints[s]], blockers.spheres[s]);
            const Vec3 center = placed.point(posed.center);
            for (const float x : {center.x, center.y, center.z, posed.radius}) *spheres++ = x;
        }
    });
}

penumbra_status penumbra_scene_ambient(const penumbra_scene* scene, size_t except, const penumbra_points* points,
                                       float* ambient, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(ambient, "ambient");
        std::array<float, kFarCoefficients> weights;
        ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
        overPoints(scene, except, points, 1, [&](std::size_t i, std::span<const float> mirrored, const Mat3&) {
            float e = 0;
            for (std::size_t k = 0; k < kFarCoefficients; ++k) e += weights[k] * mirrored[k];
            ambient[i] = std::clamp(e, 0.0f, 1.0f);
        });
    });
}

penumbra_status penumbra_scene_irradiance(const penumbra_scene* scene, size_t except, const penumbra_points* points,
                                          int order, const float* sh, float* irradiance, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(irradiance, "irradiance", sh, "sh");
        const std::size_t n = requireTransferOrder(order);
        requireFinite("sh", {sh, 3 * n});
        overPoints(scene, except, points, 3, [&](std::size_t i, std::span<const float> mirrored, const Mat3& to_local) {
            std::array<float, coefficientCount(VisibilityTransfer::kMaxTransferOrder)> transfer;
            scene->transfer.apply(mirrored, to_local, order, std::span(transfer).first(n));
            Vec3 sum;
            for (std::size_t k = 0; k < n; ++k) sum += vectors(sh, n)[k] * transfer[k];
            for (int c = 0; c < 3; ++c) irradiance[3 * i + std::size_t(c)] = sum[c];
        });
    });
}

penumbra_status penumbra_scene_transfer(const penumbra_scene* scene, size_t except, const penumbra_points* points,
                                        float* transfer, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(transfer, "transfer");
        constexpr int kOrder = VisibilityTransfer::kMaxTransferOrder;
        constexpr auto kRow = std::size_t(coefficientCount(kOrder));
        overPoints(scene, except, points, kRow,
                   [&](std::size_t i, std::span<const float> mirrored, const Mat3& to_local) {
                       scene->transfer.apply(mirrored, to_local, kOrder, {transfer + i * kRow, kRow});
                   });
    });
}

penumbra_status penumbra_ground_shadow(const penumbra_character* character, const float* to_scene,
                                       const penumbra_vertices* vertices, float* hidden, penumbra_error* error) {
    return guarded(error, [&] {
        requireReceiver(character, vertices);
        const ModelView& model = character->asset->view.model;
        const auto stride = std::size_t(model.stride);
        const Mat3 turn = rigidOf(to_scene).linear();
        const std::size_t last = vertices->first + vertices->count;
        std::array<Vec3, kMaxReceivers> positions, normals, tangents;
        std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
        std::array<float, kMaxReceivers> before, after;
        for (std::size_t at = vertices->first; at < last; at += kMaxReceivers) {
            const std::size_t n = std::min(kMaxReceivers, last - at);
            character->evaluator.skin(at, {positions.data(), n}, {normals.data(), n}, {tangents.data(), n});
            for (std::size_t i = 0; i < n; ++i) normals[i] = turn * normals[i], tangents[i] = turn * tangents[i];
            const std::span<float> coefficients{vertices->coefficients + at * stride, n * stride};
            ambient(model.convention, model.stride, coefficients, std::span(before).first(n));
            const std::span<float> used = std::span(mirrored).first(n * kFarCoefficients);
            groundVisibility({normals.data(), n}, {tangents.data(), n}, used);
            character->product(coefficients, stride, used);
            ambient(model.convention, model.stride, coefficients, std::span(after).first(n));
            for (std::size_t i = 0; hidden && i < n; ++i) hidden[at + i] = std::max(before[i] - after[i], 0.0f);
        }
    });
}

penumbra_status penumbra_scene_cast(const penumbra_scene* scene, size_t except, const penumbra_character* character,
                                    const float* to_scene, const penumbra_vertices* vertices, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(scene, "scene");
        requireReceiver(character, vertices);
        requireCaster(*scene, except);
        const Evaluator& evaluator = character->evaluator;
        const ModelView& model = character->asset->view.model;
        const Affine placed = rigidOf(to_scene);
        const Mat3 turn = placed.linear();
        const auto at = [&](std::size_t v) {
            Receiver vertex;
            evaluator.skin(v, {&vertex.position, 1}, {&vertex.normal, 1}, {&vertex.tangent, 1});
            return Receiver{placed.point(vertex.position), turn * vertex.normal, turn * vertex.tangent};
        };
        thread_local std::vector<float> mirrored;
        const std::size_t first_vertex = vertices->first, last_vertex = first_vertex + vertices->count;
        for (std::size_t c = 0; c < model.clusters.size(); ++c) {
            const std::size_t first = model.clusters[c].first_vertex;
            const std::size_t begin = std::max(first, first_vertex),
                              end = std::min(first + model.clusters[c].vertex_count, last_vertex);
            if (begin >= end) continue;
            mirrored.resize((end - begin) * kFarCoefficients);
            if (castOnCluster(*scene->cast, allBut(except), {evaluator, c, begin, end}, at, mirrored) == 0) continue;
            castOn(*character, *vertices, begin, mirrored);
        }
        const std::size_t begin = std::max(evaluator.firstFollower(), first_vertex);
        if (begin >= last_vertex) return;
        mirrored.resize((last_vertex - begin) * kFarCoefficients);
        if (castOnFollowers(*scene->cast, allBut(except), begin, last_vertex, at, mirrored) > 0)
            castOn(*character, *vertices, begin, mirrored);
    });
}
