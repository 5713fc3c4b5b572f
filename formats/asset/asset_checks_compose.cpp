// The checks of composed models and of sphere blockers.
#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"
#include "formats/common/sphere_blockers.h"
#include "sh/far/near_parts.h"

namespace penumbra {

namespace {

// Squares of such lengths, and of their inverses, are still numbers.
constexpr float kLargestLength = 1e15f;

Vec3 pointOf(const flatbuffers::Vector<float>* stored, const Field& at) {
    if (!stored || stored->size() != 3) at.fail("has not 3 elements");
    const Vec3 point{stored->Get(0), stored->Get(1), stored->Get(2)};
    for (int i = 0; i < 3; ++i) at.require(std::abs(point[i]) <= kLargestLength, "is not finite, or above 1e15");
    return point;
}

float lengthOf(float stored, const Field& at) {
    at.require(stored >= 1 / kLargestLength && stored <= kLargestLength, "is not in [1e-15, 1e15]");
    return stored;
}

FieldBox boxOf(const fbs::FieldBox& stored, const Field& at) {
    FieldBox box;
    box.low = pointOf(stored.low(), at / "low");
    box.high = pointOf(stored.high(), at / "high");
    if (!stored.size() || stored.size()->size() != 3) (at / "size").fail("has not 3 elements");
    for (int i = 0; i < 3; ++i) {
        (at / "high").require(box.low[i] < box.high[i], "is not above low");
        box.size[std::size_t(i)] = stored.size()->Get(flatbuffers::uoffset_t(i));
        checkRange((at / "size")[std::size_t(i)], box.size[std::size_t(i)], 2, 65535);
    }
    return box;
}

// Sizes of 16 bits cannot overflow the counts, which have 64.
PartFieldView partOf(const fbs::PartField& stored, const Field& at, std::size_t joints) {
    PartFieldView part;
    part.field.joint = stored.joint();
    if (stored.joint() != kStillJoint) checkRange(at / "joint", stored.joint(), 0, std::int64_t(joints) - 1);
    part.field.center = pointOf(stored.center(), at / "center");
    part.field.radius = lengthOf(stored.radius(), at / "radius");
    if (!stored.boxes() || stored.boxes()->size() != 2) (at / "boxes").fail("has not 2 elements");
    for (std::size_t b = 0; b < 2; ++b)
        part.field.boxes[b] = boxOf(*stored.boxes()->Get(flatbuffers::uoffset_t(b)), (at / "boxes")[b]);
    constexpr std::size_t kScales = kFieldLevels * kFieldOrder;
    if (!stored.scale() || stored.scale()->size() != kScales) (at / "scale").fail("has not 18 elements");
    for (std::size_t i = 0; i < kScales; ++i) {
        const float scale = stored.scale()->Get(flatbuffers::uoffset_t(i));
        (at / "scale")[i].require(scale >= 0 && scale <= kLargestLength, "is not in [0, 1e15]");
        part.field.scale[i / kFieldOrder][i % kFieldOrder] = scale;
    }
    part.field.distance_scale = lengthOf(stored.distance_scale(), at / "distance_scale");
    part.bytes.values = spanOf<std::int8_t>(stored.values(), at / "values");
    checkCount(at / "values", part.bytes.values, std::uint64_t(part.field.pointCount()) * kFieldCoefficients);
    part.bytes.distances = spanOf<std::int8_t>(stored.distances(), at / "distances");
    checkCount(at / "distances", part.bytes.distances, part.field.boxes[0].pointCount());
    return part;
}

// `composition` has its parts and steps.
void setNearParts(const fbs::Composition& stored, const Field& at, const MeshView& mesh, CompositionView& composition) {
    checkRange(at / "near_count", stored.near_count(), 0, kMaxNear);
    composition.near_count = stored.near_count();
    const std::uint64_t columns = composition.near_count;
    composition.near_parts = spanOf<std::uint16_t>(stored.near_parts(), at / "near_parts");
    checkCount(at / "near_parts", composition.near_parts, composition.parts.size() * columns);
    const std::string problem =
        findNearProblem(composition.near_parts, {composition.steps, composition.parts.size(), composition.local_steps});
    (at / "near_parts").require(problem.empty(), problem.c_str());
    composition.near_gains = spanOf<std::uint8_t>(stored.near_gains(), at / "near_gains");
    checkCount(at / "near_gains", composition.near_gains, mesh.firstFollower() * columns);
}

}  // namespace

std::vector<ClusterView> sameClustersOf(const StoredClusters* stored, const Field& at, const ModelView& model,
                                        const ReadCluster& read_cluster) {
    std::vector<ClusterView> clusters;
    if (!stored || stored->size() == 0) return clusters;
    const auto count = std::int64_t(model.clusters.size());
    checkRange(at, std::int64_t(stored->size()), count, count);
    for (const fbs::Cluster* cluster : *stored) {
        const Field here = at[clusters.size()];
        const ClusterView& own = model.clusters[clusters.size()];
        checkRange(here / "joint", cluster->joint(), own.joint, own.joint);
        checkRange(here / "first_vertex", cluster->first_vertex(), own.first_vertex, own.first_vertex);
        checkRange(here / "vertex_count", cluster->vertex_count(), own.vertex_count, own.vertex_count);
        clusters.push_back(read_cluster(*cluster, here));
    }
    return clusters;
}

void setComposition(const fbs::Model& stored, const Field& model_at, const AssetView& asset,
                    const ReadCluster& read_cluster, ModelView& model) {
    if (!stored.composition()) return;
    const fbs::Composition& composed = *stored.composition();
    const Field at = model_at / "composition";
    at.require(model.convention.below == BelowHorizon::kMirrored, "is given, but the convention is not mirrored (D)");
    CompositionView composition;
    composition.local_steps = composed.local_steps();
    composition.floor = composed.floor();
    if (!composed.fields() || composed.fields()->size() == 0) (at / "fields").fail("is missing");
    const std::size_t parts = composed.fields()->size();
    checkRange(at / "fields", std::int64_t(parts), 1, 65535);
    for (const fbs::PartField* part : *composed.fields())
        composition.parts.push_back(
            partOf(*part, (at / "fields")[composition.parts.size()], asset.animation.jointCount()));
    composition.fade = lengthOf(composed.fade(), at / "fade");
    composition.steps = spanOf<std::uint8_t>(composed.steps(), at / "steps");
    checkCount(at / "steps", composition.steps, std::uint64_t(parts) * parts);
    composition.part_of_vertex = spanOf<std::uint16_t>(composed.part_of_vertex(), at / "part_of_vertex");
    checkCount(at / "part_of_vertex", composition.part_of_vertex, asset.mesh.positions.size());
    checkIndices(at / "part_of_vertex", composition.part_of_vertex, parts);
    setNearParts(composed, at, asset.mesh, composition);
    composition.residual = sameClustersOf(composed.residual(), at / "residual", model, read_cluster);
    model.composition = std::move(composition);
}

BlockersView blockersOf(const fbs::Asset& stored, const Field& file, std::size_t joints) {
    static_assert(sizeof(CasterSphere) == 4 * sizeof(float));
    const Field at = file / "blocker_spheres";
    BlockersView blockers;
    blockers.spheres = spanOf<CasterSphere>(stored.blocker_spheres(), at);
    checkRange(at, std::int64_t(blockers.spheres.size()), 0, std::int64_t(kMaxBlockers));
    for (std::size_t s = 0; s < blockers.spheres.size(); ++s) {
        const CasterSphere& sphere = blockers.spheres[s];
        for (int i = 0; i < 3; ++i)
            at[s].require(std::abs(sphere.center[i]) <= kLargestBlockerLength,
                          "has a center that is not finite, or above 1e15");
        at[s].require(sphere.radius >= 1 / kLargestBlockerLength && sphere.radius <= kLargestBlockerLength,
                      "has a radius that is not in [1e-15, 1e15]");
    }
    if (const auto* stored_joints = stored.blocker_joints())
        blockers.joints = {stored_joints->data(), stored_joints->size()};
    checkCount(file / "blocker_joints", blockers.joints, blockers.spheres.size());
    checkIndices(file / "blocker_joints", blockers.joints, joints);
    return blockers;
}

}  // namespace penumbra
