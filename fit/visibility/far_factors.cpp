#include "fit/visibility/far_factors.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "fit/clusters/tangent_frames.h"

namespace penumbra {

FarTables makeFarTables(const Composition& composition) {
    FarTables tables;
    const PartFields& fields = composition.fields;
    for (std::size_t p = 0; p < fields.parts.size(); ++p) {
        tables.fields.tables.push_back(makeFieldTable(fields.parts[p], fields.bytesOf(p), fields.fade));
        tables.fields.joints.push_back(fields.parts[p].joint);
    }
    tables.far = farParts(composition.steps, fields.parts.size(), composition.local_steps);
    return tables;
}

VertexSet vertexSet(const Model& model, std::span<const std::uint32_t> vertices,
                    std::span<const int> joint_of_cluster) {
    VertexSet set;
    const Skin& skin = model.skin;
    const auto k = std::size_t(skin.influences);
    set.skin.joint_names = skin.joint_names;
    set.skin.parents = skin.parents;
    set.skin.influences = skin.influences;
    for (const std::uint32_t v : vertices) {
        set.mesh.rest_positions.push_back(model.mesh.rest_positions[v]);
        set.rest_normals.push_back(model.rest_normals[v]);
        set.rest_tangents.push_back(model.rest_tangents[v]);
        set.part.push_back(model.composition->part_of_vertex[v]);
        set.joint.push_back(std::uint16_t(joint_of_cluster[model.cluster_of_vertex[v]]));
        for (std::size_t i = v * k; i < (v + 1) * k; ++i) {
            set.skin.joints.push_back(skin.joints[i]);
            set.skin.weights.push_back(skin.weights[i]);
        }
    }
    return set;
}

void farFactors(const FarTables& tables, const VertexSet& set, std::span<const Affine> bones,
                std::span<const PosedPart> posed, std::span<float> out) {
    assert(out.size() == set.part.size() * kFarNumbers);
    std::vector<Vec3> positions, normals;
    skinVertices(set.mesh, set.skin, set.rest_normals, {bones.begin(), bones.end()}, positions, normals);
    std::vector<Mat3> rotations(bones.size());
    std::vector<bool> known(bones.size());
    for (std::size_t v = 0; v < set.part.size(); ++v) {
        const std::size_t joint = set.joint[v];
        if (!known[joint]) rotations[joint] = nearestRotation(bones[joint].linear());
        known[joint] = true;
        const Vec3 tangent = carriedTangent(normals[v], rotations[joint], set.rest_tangents[v]);
        farVisibility(tables.fields, posed, tables.far[set.part[v]], {positions[v], normals[v], tangent},
                      out.subspan(v * kFarNumbers, kFarNumbers));
    }
}

void multiplyByFar(const Convention& convention, std::span<const float> far, std::span<float> numbers) {
    assert(convention.below == BelowHorizon::kMirrored);
    const auto n = std::size_t(convention.size());
    std::array<float, mirroredCount(kMaxOrder)> product;
    for (std::size_t v = 0; v * n < numbers.size(); ++v) {
        const std::span<float> vertex = numbers.subspan(v * n, n), sum = std::span(product).first(n);
        multiplyMirrored(convention.order, vertex, convention.order, far.subspan(v * kFarNumbers, kFarNumbers),
                         kFieldOrder, sum);
        for (std::size_t i = 0; i < n; ++i) vertex[i] = sum[i];
    }
}

}  // namespace penumbra
