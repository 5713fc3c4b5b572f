// The checks behind openAsset(). Sizes are compared in 64 bits before anything is read through them.
#include "formats/asset/asset_checks.h"

#include <cmath>

#include "formats/asset/asset_field.h"
#include "formats/asset/asset_kinds.h"

namespace penumbra {

NumbersView numbersOf(const fbs::Numbers* stored, const Field& at, std::uint64_t rows, std::uint64_t row_length,
                      AssetPrecision coarsest) {
    if (!stored) at.fail("is missing");
    NumbersView view;
    checkRange(at / "precision", std::int64_t(stored->precision()), 0, std::int64_t(coarsest));
    view.precision = AssetPrecision(stored->precision());
    view.count = stored->count();
    view.row_length = stored->row_length();
    checkRange(at / "count", std::int64_t(view.count), std::int64_t(rows * row_length),
               std::int64_t(rows * row_length));
    checkRange(at / "row_length", std::int64_t(view.row_length), std::int64_t(row_length), std::int64_t(row_length));
    const auto data = spanOf<std::byte>(stored->data(), at / "data");
    checkCount(at / "data", data, std::uint64_t(view.count) * bytesPerNumber(view.precision));
    view.data = data.data();
    const bool scaled = view.precision == AssetPrecision::kI8;
    view.scale = floatsOf(stored->scale(), at / "scale", scaled ? rows : 0);
    if (view.precision == AssetPrecision::kF32)
        (at / "data").require(finiteFloats(view.data, view.count), "has a number that is not finite");
    if (view.precision == AssetPrecision::kF16)
        (at / "data").require(finiteHalves(view.data, view.count), "has a number that is not finite");
    return view;
}

namespace {

void checkWeights(const Field& at, std::span<const float> weights, std::size_t influences) {
    for (std::size_t first = 0; first + influences <= weights.size(); first += influences) {
        double sum = 0;
        for (float w : weights.subspan(first, influences)) {
            if (!(w >= 0)) at[first].fail("is negative");
            sum += w;
        }
        if (!(std::abs(sum - 1) < 1e-3)) at[first].fail("starts a row that does not sum to 1");
    }
}

void checkPermutation(const Field& at, std::span<const std::uint32_t> indices) {
    checkIndices(at, indices, indices.size());
    std::vector<bool> seen(indices.size());
    for (std::uint32_t index : indices) {
        if (seen[index]) at.fail("has " + std::to_string(index) + " twice");
        seen[index] = true;
    }
}

MeshView meshOf(const fbs::Mesh& stored, const Field& at, std::size_t joints, bool has_model) {
    MeshView mesh;
    mesh.positions = spanOf<Vec3>(stored.positions(), at / "positions");
    checkFinite(at / "positions", mesh.positions);
    const std::size_t count = mesh.positions.size();
    (at / "positions").require(count > 0, "is empty");
    mesh.normals = vectorsOf(stored.normals(), at / "normals", count);
    checkUnit(at / "normals", mesh.normals);
    mesh.tangents = vectorsOf(stored.tangents(), at / "tangents", has_model ? count : 0);
    checkUnit(at / "tangents", mesh.tangents);
    mesh.triangles = requiredSpanOf<std::uint32_t>(stored.triangles(), at / "triangles");
    (at / "triangles").require(mesh.triangles.size() % 3 == 0, "has a broken last triangle");
    checkIndices(at / "triangles", mesh.triangles, count);
    mesh.shading_point = spanOf<std::uint32_t>(stored.shading_point(), at / "shading_point");
    checkCount(at / "shading_point", mesh.shading_point, count);
    checkPermutation(at / "shading_point", mesh.shading_point);
    mesh.source_vertex = requiredSpanOf<std::uint32_t>(stored.source_vertex(), at / "source_vertex");
    checkIndices(at / "source_vertex", mesh.source_vertex, count);
    mesh.influences = stored.influences();
    (at / "influences").require(mesh.influences > 0 || !has_model, "is 0 in a file with a model");
    mesh.skin_joints = spanOf<std::uint16_t>(stored.skin_joints(), at / "skin_joints");
    checkCount(at / "skin_joints", mesh.skin_joints, std::uint64_t(count) * mesh.influences);
    checkIndices(at / "skin_joints", mesh.skin_joints, joints);
    mesh.skin_weights = floatsOf(stored.skin_weights(), at / "skin_weights", std::uint64_t(count) * mesh.influences);
    if (mesh.influences > 0) checkWeights(at / "skin_weights", mesh.skin_weights, mesh.influences);
    if (stored.slots())
        for (const flatbuffers::String* slot : *stored.slots()) mesh.slots.push_back(textOf(slot));
    checkUniqueNames(at / "slots", mesh.slots);
    mesh.slot_of_vertex = spanOf<std::uint16_t>(stored.slot_of_vertex(), at / "slot_of_vertex");
    checkCount(at / "slot_of_vertex", mesh.slot_of_vertex, mesh.slots.empty() ? 0 : count);
    checkIndices(at / "slot_of_vertex", mesh.slot_of_vertex, mesh.slots.size());
    mesh.casting = spanOf<std::uint32_t>(stored.casting(), at / "casting");
    (at / "casting").require(mesh.casting.size() % 3 == 0, "has a broken last triangle");
    checkIndices(at / "casting", mesh.casting, count);
    setTwoSided(stored, at, mesh);
    return mesh;
}

// Checks that every joint reaches a root. Otherwise a reader who follows the parents would never end.
void checkParents(const Field& at, std::span<const std::int32_t> parents) {
    std::vector<std::uint8_t> state(parents.size());  // 1: on the path being followed, 2: known to reach a root
    for (std::size_t start = 0; start < parents.size(); ++start) {
        std::vector<std::size_t> path;
        for (std::int64_t j = std::int64_t(start); j >= 0 && state[j] != 2; j = parents[j]) {
            checkRange(at[j], parents[j], -1, std::int64_t(parents.size()) - 1);
            at[j].require(state[j] == 0, "is part of a cycle");
            state[j] = 1;
            path.push_back(std::size_t(j));
        }
        for (std::size_t j : path) state[j] = 2;
    }
}

std::vector<ClipView> clipsOf(const fbs::Animation& stored, const Field& at, std::size_t frames) {
    std::vector<ClipView> clips;
    std::uint64_t next = 0;
    for (const fbs::Clip* clip : *stored.clips()) {
        checkRange(at[clips.size()] / "first_frame", clip->first_frame(), std::int64_t(next), std::int64_t(next));
        clips.push_back({textOf(clip->name()), clip->first_frame(), clip->frame_count(), clip->held_out()});
        next += clip->frame_count();
    }
    if (next != frames) at.fail("cover " + std::to_string(next) + " of " + std::to_string(frames) + " frames");
    checkUniqueNames(at, clips);
    return clips;
}

AnimationView animationOf(const fbs::Animation& stored, const Field& at) {
    AnimationView animation;
    if (!stored.joint_names()) (at / "joint_names").fail("is missing");
    for (const flatbuffers::String* name : *stored.joint_names()) animation.joint_names.push_back(textOf(name));
    checkUniqueNames(at / "joint_names", animation.joint_names);
    const std::size_t joints = animation.jointCount();
    checkRange(at / "joint_names", std::int64_t(joints), 0, 65535);
    animation.parents = spanOf<std::int32_t>(stored.parents(), at / "parents");
    checkCount(at / "parents", animation.parents, joints);
    checkParents(at / "parents", animation.parents);
    animation.times = requiredSpanOf<double>(stored.times(), at / "times");
    const std::size_t frames = animation.times.size();
    for (double time : animation.times) (at / "times").require(std::isfinite(time), "has a number that is not finite");
    if (!stored.clips()) (at / "clips").fail("is missing");
    animation.clips = clipsOf(stored, at / "clips", frames);
    animation.bones = spanOf<Affine>(stored.bones(), at / "bones");
    if (!animation.bones.empty()) checkCount(at / "bones", animation.bones, std::uint64_t(frames) * joints);
    checkFinite(at / "bones", animation.bones);
    animation.pose_size = stored.pose_size();
    const bool has_pose = stored.pose() && stored.pose()->size() > 0;
    animation.pose = floatsOf(stored.pose(), at / "pose", has_pose ? std::uint64_t(frames) * animation.pose_size : 0);
    animation.rest_transforms = spanOf<Affine>(stored.rest_transforms(), at / "rest_transforms");
    const std::size_t rests = animation.rest_transforms.empty() ? 0 : joints;
    checkCount(at / "rest_transforms", animation.rest_transforms, rests);
    checkFinite(at / "rest_transforms", animation.rest_transforms);
    animation.inverse_bind = spanOf<Affine>(stored.inverse_bind(), at / "inverse_bind");
    checkCount(at / "inverse_bind", animation.inverse_bind, rests);
    checkFinite(at / "inverse_bind", animation.inverse_bind);
    setInputs(stored, at, animation);
    return animation;
}

// The numbers that the sizes of a cluster follow from.
struct ModelSizes {
    ModelKind kind = ModelKind::kLinear;
    bool bones = false;  // true: a group is another joint; false: numbers of the pose
    std::uint64_t group_size = 0, stride = 0, features = 0, joints = 0, groups = 0;
    AssetPrecision coarsest_mean = AssetPrecision::kF16;
};

void setGroups(const fbs::Cluster& stored, const Field& at, const ModelSizes& sizes, ClusterView& cluster) {
    const std::uint64_t size = sizes.group_size;
    cluster.groups = requiredSpanOf<std::uint16_t>(stored.groups(), at / "groups");
    checkIndices(at / "groups", cluster.groups, sizes.groups);
    for (std::size_t g = 0; g < cluster.groups.size(); ++g) {
        const Field here = (at / "groups")[g];
        here.require(g == 0 || cluster.groups[g] > cluster.groups[g - 1], "is not above the one before");
        here.require(!sizes.bones || int(cluster.groups[g]) != cluster.joint, "is the cluster's own joint");
    }
    const std::uint64_t groups = cluster.groups.size();
    cluster.group_weight = floatsOf(stored.group_weight(), at / "group_weight", groups);
    cluster.group_min = numbersOf(stored.group_min(), at / "group_min", groups, size, AssetPrecision::kF16);
    cluster.group_max = numbersOf(stored.group_max(), at / "group_max", groups, size, AssetPrecision::kF16);
    std::vector<float> least(cluster.group_min.count), most(cluster.group_max.count);
    decode(cluster.group_min, least);
    decode(cluster.group_max, most);
    for (std::size_t i = 0; i < least.size(); ++i)
        (at / "group_max")[i].require(least[i] <= most[i], "is below group_min");
}

void setUnits(const fbs::Cluster& stored, const Field& at, const ModelSizes& sizes, ClusterView& cluster) {
    const std::uint64_t inputs = cluster.inputs();
    std::uint64_t width = 0;
    cluster.units = inputs;
    if (sizes.kind == ModelKind::kQuadratic) cluster.units = quadraticUnits(inputs);
    if (sizes.kind == ModelKind::kNeural) {
        if (!stored.hidden()) (at / "hidden").fail("is missing");
        width = inputs + 1;
        cluster.units = stored.hidden()->count() / width;
    }
    cluster.unit_group = requiredSpanOf<std::uint16_t>(stored.unit_group(), at / "unit_group");
    checkIndices(at / "unit_group", cluster.unit_group, cluster.groups.size());
    if (sizes.kind == ModelKind::kAdditive) {
        width = sizes.group_size;
        cluster.units = cluster.unit_group.size();
    } else {
        checkCount(at / "unit_group", cluster.unit_group, 0);
    }
    cluster.hidden = numbersOf(stored.hidden(), at / "hidden", width ? cluster.units : 0, width, AssetPrecision::kI8);
    cluster.weights =
        numbersOf(stored.weights(), at / "weights", cluster.components(), cluster.units, AssetPrecision::kI8);
}

ClusterView clusterOf(const fbs::Cluster& stored, const Field& at, const ModelSizes& sizes) {
    ClusterView cluster;
    const std::uint64_t features = sizes.features, joints = sizes.joints, stride = sizes.stride;
    const auto center = vectorsOf(stored.center(), at / "center", 1);
    cluster.center = center[0];
    cluster.joint = stored.joint();
    checkRange(at / "joint", cluster.joint, 0, std::int64_t(joints) - 1);
    cluster.first_vertex = stored.first_vertex();
    cluster.vertex_count = stored.vertex_count();
    (at / "vertex_count").require(cluster.vertex_count > 0, "is 0");
    cluster.feature_mean = floatsOf(stored.feature_mean(), at / "feature_mean", features);
    cluster.input_min = requiredSpanOf<float>(stored.input_min(), at / "input_min");
    checkFinite(at / "input_min", cluster.input_min);
    const std::uint64_t inputs = cluster.inputs();
    // There are no more inputs than features, as principal components cannot be more. Otherwise a small file could
    // ask for the squares of a great many.
    checkRange(at / "input_min", std::int64_t(inputs), 0, std::int64_t(features));
    cluster.input_max = floatsOf(stored.input_max(), at / "input_max", inputs);
    for (std::size_t i = 0; i < inputs; ++i)
        (at / "input_max")[i].require(cluster.input_min[i] <= cluster.input_max[i], "is below input_min");
    cluster.input_basis = numbersOf(stored.input_basis(), at / "input_basis", inputs, features, AssetPrecision::kI8);
    cluster.bias = requiredSpanOf<float>(stored.bias(), at / "bias");
    checkFinite(at / "bias", cluster.bias);
    const std::uint64_t components = cluster.components(), row = std::uint64_t(cluster.vertex_count) * stride;
    setGroups(stored, at, sizes, cluster);
    setUnits(stored, at, sizes, cluster);
    cluster.mean = numbersOf(stored.mean(), at / "mean", 1, row, sizes.coarsest_mean);
    cluster.basis = numbersOf(stored.basis(), at / "basis", components, row, AssetPrecision::kI8);
    return cluster;
}

ModelSizes sizesOf(const ModelView& model, const Field& at, const AnimationView& animation) {
    const std::uint64_t joints = animation.jointCount(), pose = animation.pose_size;
    const std::uint64_t own = joints - model.input_joints.size();  // each is another joint
    if (model.features == FeatureKind::kJointAngles && pose != 3 * own + animation.input_names.size())
        at.fail("reads joint angles, but animation.pose_size is not 3 for each of the " + std::to_string(own) +
                " joints, and the inputs");
    ModelSizes sizes;
    sizes.kind = model.kind;
    sizes.bones = model.features == FeatureKind::kRelativeBones;
    sizes.group_size = groupInputs(model.features);
    sizes.stride = std::uint64_t(model.stride);
    if (model.kind != ModelKind::kAdditive) sizes.features = featureCount(model.features, joints, pose);
    sizes.joints = joints;
    sizes.groups = groupCount(model.features, joints, pose);
    return sizes;
}

ModelView modelOf(const fbs::Model& stored, const Field& file, const AssetView& asset) {
    const Field at = file / "model";
    const AnimationView& animation = asset.animation;
    const std::size_t vertices = asset.mesh.positions.size();
    ModelView model;
    checkRange(at / "kind", std::int64_t(stored.kind()), 0, std::int64_t(fbs::ModelKind::MAX));
    model.kind = fromStored(stored.kind());
    checkRange(at / "features", std::int64_t(stored.features()), 0, std::int64_t(fbs::FeatureKind::MAX));
    model.features = fromStored(stored.features());
    try {
        model.convention = parseConvention(textOf(stored.convention()));
    } catch (const std::invalid_argument& error) {
        (at / "convention").fail(std::string("is wrong: ") + error.what());
    }
    model.stride = stored.stride();
    const int expected_stride = (model.convention.size() + 3) / 4 * 4;
    checkRange(at / "stride", model.stride, expected_stride, expected_stride);
    const std::size_t joints = animation.jointCount();
    at.require(joints > 0, "needs joints");
    model.joint_centers = vectorsOf(stored.joint_centers(), at / "joint_centers", joints);
    model.joint_spreads = spanOf<Mat3>(stored.joint_spreads(), at / "joint_spreads");
    checkCount(at / "joint_spreads", model.joint_spreads, joints);
    checkFinite(at / "joint_spreads", model.joint_spreads);
    model.feature_scale = stored.feature_scale();
    (at / "feature_scale").require(std::isfinite(model.feature_scale) && model.feature_scale > 0, "is not positive");
    model.quantization_error = stored.quantization_error();
    (at / "quantization_error")
        .require(std::isfinite(model.quantization_error) && model.quantization_error >= 0, "is not a number >= 0");
    setDeforming(stored, file, asset, model);
    const ModelSizes sizes = sizesOf(model, at, animation);
    std::uint64_t next = 0;
    if (!stored.clusters()) (at / "clusters").fail("is missing");
    for (const fbs::Cluster* cluster : *stored.clusters()) {
        const Field here = (at / "clusters")[model.clusters.size()];
        checkRange(here / "first_vertex", cluster->first_vertex(), std::int64_t(next), std::int64_t(next));
        next += cluster->vertex_count();
        checkRange(here / "vertex_count", cluster->vertex_count(), 1, std::int64_t(vertices));
        model.clusters.push_back(clusterOf(*cluster, here, sizes));
    }
    if (next != vertices)
        (at / "clusters").fail("cover " + std::to_string(next) + " of " + std::to_string(vertices) + " vertices");
    setComposition(
        stored, at, asset,
        [&](const fbs::Cluster& cluster, const Field& here) { return clusterOf(cluster, here, sizes); }, model);
    ModelSizes of_indirect = sizes;
    of_indirect.stride = kIndirectStride;
    of_indirect.coarsest_mean = AssetPrecision::kI8;
    setIndirect(
        stored, at,
        [&](const fbs::Cluster& cluster, const Field& here) { return clusterOf(cluster, here, of_indirect); }, model);
    return model;
}

TruthView truthOf(const fbs::Truth& stored, const Field& at, std::size_t vertices, std::size_t frames) {
    TruthView truth;
    truth.order = stored.order();
    truth.is_transfer = stored.is_transfer();
    checkRange(at / "order", truth.order, 1, kMaxOrder);
    checkRange(at / "precision", std::int64_t(stored.precision()), 0, std::int64_t(AssetPrecision::kF16));
    truth.precision = AssetPrecision(stored.precision());
    truth.data = spanOf<std::byte>(stored.data(), at / "data");
    const std::uint64_t count = std::uint64_t(frames) * vertices * std::uint64_t(truth.order * truth.order);
    checkCount(at / "data", truth.data, count * bytesPerNumber(truth.precision));
    const bool finite = truth.precision == AssetPrecision::kF32 ? finiteFloats(truth.data.data(), count)
                                                                : finiteHalves(truth.data.data(), count);
    (at / "data").require(finite, "has a number that is not finite");
    return truth;
}

}  // namespace

AssetView viewOfAsset(const fbs::Asset& stored, const std::string& file) {
    const Field at{file + ": "};
    if (textOf(stored.sh_convention()) != kShConvention) (at / "sh_convention").fail("is not real-orthonormal-cs");
    AssetView asset;
    asset.provenance = textOf(stored.provenance());
    if (stored.animation()) asset.animation = animationOf(*stored.animation(), at / "animation");
    asset.has_mesh = stored.mesh() != nullptr;
    asset.has_model = stored.model() != nullptr;
    asset.has_truth = stored.truth() != nullptr;
    (at / "mesh").require(asset.has_mesh || !(asset.has_model || asset.has_truth || stored.transfer()), "is missing");
    const std::size_t joints = asset.animation.jointCount();
    if (asset.has_mesh) asset.mesh = meshOf(*stored.mesh(), at / "mesh", joints, asset.has_model);
    const std::size_t vertices = asset.mesh.positions.size();
    if (asset.has_model) asset.model = modelOf(*stored.model(), at, asset);
    if (stored.transfer()) setTransfer(stored, at, asset);
    setMorphs(stored, at, asset);
    if (!asset.model.deforming)
        checkCount(at / "animation.bones", asset.animation.bones, asset.animation.frameCount() * std::uint64_t(joints));
    if (stored.animation()) setPlayback(*stored.animation(), at / "animation", asset, asset.animation.playback);
    if (asset.has_truth) asset.truth = truthOf(*stored.truth(), at / "truth", vertices, asset.animation.frameCount());
    asset.materials = materialsOf(stored, at / "materials");
    asset.lights = lightsOf(stored, at / "lights");
    asset.slot_material = slotMaterialsOf(stored, at, asset);
    checkLooks(asset, at);
    asset.blockers = blockersOf(stored, at, joints);
    return asset;
}

}  // namespace penumbra
