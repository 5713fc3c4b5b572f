#include "fit/visibility/far_factors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <optional>
#include <utility>

#include "fit/clusters/tangent_frames.h"
#include "sh/far/floor_factor.h"

namespace penumbra {

FarTables makeFarTables(const Composition& composition, const Convention& convention) {
    const PartFields& parts = composition.fields;
    FarFields fields;
    for (std::size_t p = 0; p < parts.parts.size(); ++p) {
        fields.tables.push_back(makeFieldTable(parts.parts[p], parts.bytesOf(p), parts.fade));
        fields.joints.push_back(parts.parts[p].joint);
    }
    fields.floor = composition.floor;
    auto far = farParts(composition.steps, parts.parts.size(), composition.local_steps);
    return {std::move(fields), std::move(far), convention.order, {composition.near_count, composition.near_parts}};
}

VertexSet vertexSet(const Model& model, std::span<const std::uint32_t> vertices,
                    std::span<const int> joint_of_cluster) {
    VertexSet set;
    const Skin& skin = model.skin;
    const auto k = std::size_t(skin.influences), nears = model.composition->near_count;
    set.skin.joint_names = skin.joint_names;
    set.skin.parents = skin.parents;
    set.skin.influences = skin.influences;
    set.id.assign(vertices.begin(), vertices.end());
    set.mesh.morphs = selectVertices(model.mesh.morphs, vertices);
    set.input_joints = model.input_joints;
    set.inputs = model.input_names.size();
    for (const std::uint32_t v : vertices) {
        set.mesh.rest_positions.push_back(model.mesh.rest_positions[v]);
        set.rest_normals.push_back(model.rest_normals[v]);
        set.rest_tangents.push_back(model.rest_tangents[v]);
        set.part.push_back(model.composition->part_of_vertex[v]);
        set.joint.push_back(std::uint16_t(joint_of_cluster[model.cluster_of_vertex[v]]));
        for (std::size_t n = v * nears; n < (v + 1) * nears; ++n) set.gains.push_back(model.composition->near_gains[n]);
        for (std::size_t i = v * k; i < (v + 1) * k; ++i) {
            set.skin.joints.push_back(skin.joints[i]);
            set.skin.weights.push_back(skin.weights[i]);
        }
    }
    set.order.resize(set.part.size());
    std::iota(set.order.begin(), set.order.end(), 0u);
    std::stable_sort(set.order.begin(), set.order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return set.part[a] < set.part[b]; });
    return set;
}

namespace {

// Vertices of one part, skinned, as many as the kernel takes at once.
struct FarBatch {
    std::array<Vec3, kMaxReceivers> positions, normals, tangents;
    std::array<std::uint32_t, kMaxReceivers> vertex;
    std::array<std::uint8_t, kMaxReceivers * kMaxNear> gains;
    std::size_t count = 0;
    std::uint16_t part = 0;

    FarReceivers receivers(const std::uint8_t* gains_of_call) const {
        return {positions.data(), normals.data(), tangents.data(), count, gains_of_call};
    }
};

}  // namespace

PosedVertices skinned(const VertexSet& set, std::span<const Affine> bones) {
    RestShape vertices;
    const std::vector<Affine> all(bones.begin(), bones.end());
    const std::vector<float> weights = morphWeights(set.input_joints, bones, set.inputs, set.mesh.morphs.count());
    skinMorphed(set.mesh, set.skin, set.rest_normals, {all, weights}, vertices);
    return {std::move(vertices.positions), std::move(vertices.normals)};
}

PosedVertices deformed(const VertexSet& set, std::span<const Vec3> positions, std::span<const Vec3> normals) {
    PosedVertices vertices;
    for (const std::uint32_t v : set.id) {
        const std::size_t front = v % positions.size();
        vertices.positions.push_back(positions[front]);
        vertices.normals.push_back(v < positions.size() ? normals[front] : -normals[front]);
    }
    return vertices;
}

SetPose poseOfSet(const VertexSet& set, const PoseTable& poses, std::size_t frame, std::span<const PosedPart> parts) {
    const std::span<const Affine> bones = poses.bonesOf(frame);
    if (!poses.deforming) return {skinned(set, bones), bones, parts};
    const std::size_t fronts = poses.positions.size() / poses.frameCount();
    return {deformed(set, std::span(poses.positions).subspan(frame * fronts, fronts),
                     std::span(poses.normals).subspan(frame * fronts, fronts)),
            bones, parts};
}

namespace {

// Takes the vertices that follow `next` in the set and are of one part.
FarBatch nextBatch(const VertexSet& set, const SetPose& pose, std::vector<std::optional<Mat3>>& rotations,
                   std::size_t& next) {
    const std::uint16_t part = set.part[set.order[next]];
    const std::size_t nears = set.gains.size() / set.part.size();
    FarBatch batch;
    batch.part = part;
    for (; next < set.order.size() && batch.count < kMaxReceivers && set.part[set.order[next]] == part; ++next) {
        const std::uint32_t v = set.order[next];
        const std::size_t joint = set.joint[v], i = batch.count++;
        if (!rotations[joint]) rotations[joint] = nearestRotation(pose.bones[joint].linear());
        batch.vertex[i] = v;
        batch.positions[i] = pose.vertices.positions[v];
        batch.normals[i] = pose.vertices.normals[v];
        batch.tangents[i] = carriedTangent(pose.vertices.normals[v], *rotations[joint], set.rest_tangents[v]);
        std::copy_n(set.gains.begin() + std::ptrdiff_t(v * nears), nears,
                    batch.gains.begin() + std::ptrdiff_t(i * nears));
    }
    return batch;
}

// Calls see(parts, batch, far) for all vertices, batch by batch; it writes what they see, [count, kFarCoefficients].
template <class See>
void seeParts(const VertexSet& set, const SetPose& pose, std::span<float> out, const See& see) {
    assert(out.size() == set.part.size() * kFarCoefficients);
    std::vector<FarPart> parts;
    for (const PosedPart& part : pose.parts) parts.push_back(farPart(part));
    std::vector<std::optional<Mat3>> rotations(pose.bones.size());
    std::array<float, kMaxReceivers * kFarCoefficients> far;
    for (std::size_t next = 0; next < set.order.size();) {
        const FarBatch batch = nextBatch(set, pose, rotations, next);
        see(parts.data(), batch, far);
        for (std::size_t i = 0; i < batch.count; ++i)
            std::copy_n(far.begin() + std::ptrdiff_t(i * kFarCoefficients), kFarCoefficients,
                        out.begin() + std::ptrdiff_t(batch.vertex[i] * kFarCoefficients));
    }
}

}  // namespace

void farFactors(const FarTables& tables, const VertexSet& set, const SetPose& pose, std::span<float> out) {
    seeParts(set, pose, out, [&](const FarPart* parts, const FarBatch& batch, std::span<float> far) {
        fastestFarPath().far(tables.constants(), tables.sceneOf(batch.part, parts), {},
                             batch.receivers(batch.gains.data()), far.data());
        if (tables.fields().floor)
            multiplyByFloor(fastestFarPath(), std::span(batch.normals).first(batch.count),
                            std::span(batch.tangents).first(batch.count), far.first(batch.count * kFarCoefficients));
    });
}

void nearFactor(const FarTables& tables, const VertexSet& set, const SetPose& pose,
                std::span<const std::uint16_t> near_part, std::span<float> out) {
    std::array<std::uint8_t, kMaxReceivers> ones;
    ones.fill(std::uint8_t(1 / kPerGain));
    seeParts(set, pose, out, [&](const FarPart* parts, const FarBatch& batch, std::span<float> far) {
        const FarScene scene{tables.tables(), parts, nullptr, 0, 0, &near_part[batch.part], 1};
        fastestFarPath().far(tables.constants(), scene, {}, batch.receivers(ones.data()), far.data());
    });
}

void multiplyByFar(const FarTables& tables, std::span<const float> far, std::span<float> coefficients) {
    const FarConstants& constants = tables.constants();
    fastestFarPath().compose(constants, far.data(), nullptr, far.size() / kFarCoefficients,
                             std::size_t(mirroredCount(constants.order)), coefficients.data());
}

}  // namespace penumbra
