#include "formats/stage/model_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/clip_errors.h"
#include "formats/stage/drawn_mesh_stored.h"
#include "formats/stage/model_deforming.h"
#include "formats/stage/morphs_stored.h"
#include "formats/stage/part_fields_stored.h"
#include "formats/stage/stage_parts.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

namespace {

std::string clusterGroup(std::size_t index, const char* parent = "/clusters") {
    char name[32];
    std::snprintf(name, sizeof name, "%s/%04zu", parent, index);
    return name;
}

}  // namespace

// --- Writing --------------------------------------------------------------------------------------------------------

namespace {

void writeGroups(hid_t file, const std::string& name, const ClusterModel& cluster) {
    const hsize_t groups = cluster.groups.size(), size = groups ? cluster.group_min.size() / groups : 0;
    writeIndices(file, name + "/groups", cluster.groups);
    writeFloats(file, name + "/group_weight", cluster.group_weight, {groups});
    writeFloats(file, name + "/group_min", cluster.group_min, {groups, size});
    writeFloats(file, name + "/group_max", cluster.group_max, {groups, size});
    const hsize_t units = cluster.hidden.empty() ? 0 : cluster.units();
    writeIndices(file, name + "/unit_group", cluster.unit_group);
    writeFloats(file, name + "/hidden", cluster.hidden, {units, units ? cluster.hidden.size() / units : 0});
    writeFloats(file, name + "/center", {&cluster.center.x, 3}, {3});
}

void writeCluster(hid_t file, const std::string& group, const ClusterModel& cluster, std::size_t stride) {
    const hsize_t inputs = cluster.input_min.size(), components = cluster.components();
    const hsize_t raw = cluster.feature_mean.size(), vertices = cluster.vertices.size();
    writeIndices(file, group + "/vertices", cluster.vertices);
    writeFloats(file, group + "/feature_mean", cluster.feature_mean, {raw});
    writeFloats(file, group + "/input_basis", cluster.input_basis, {inputs, raw});
    writeFloats(file, group + "/input_min", cluster.input_min, {inputs});
    writeFloats(file, group + "/input_max", cluster.input_max, {inputs});
    writeGroups(file, group, cluster);
    writeFloats(file, group + "/weights", cluster.weights, {components, cluster.units()});
    writeFloats(file, group + "/bias", cluster.bias, {components});
    writeFloats(file, group + "/mean", cluster.mean, {vertices, stride});
    writeFloats(file, group + "/basis", cluster.basis, {components, vertices, stride});
    writeIntegerAttribute(file, group, "joint", cluster.joint);
    writeNumberAttribute(file, group, "ridge", cluster.ridge);
    writeNumberAttribute(file, group, "train_error", cluster.train_error);
    if (std::isfinite(cluster.holdout_error)) writeNumberAttribute(file, group, "holdout_error", cluster.holdout_error);
}

void writeNearParts(hid_t file, const Composition& composition) {
    if (composition.near_count == 0) return;
    const hsize_t columns = composition.near_count;
    writeIntegers(file, "/composition/near_parts",
                  std::vector<std::int64_t>(composition.near_parts.begin(), composition.near_parts.end()),
                  {composition.fields.parts.size(), columns}, H5T_STD_U16LE);
    writeIntegers(file, "/composition/near_gains",
                  std::vector<std::int64_t>(composition.near_gains.begin(), composition.near_gains.end()),
                  {composition.part_of_vertex.size(), columns}, H5T_STD_U8LE);
}

void writeComposition(hid_t file, const Model& model) {
    if (!model.composition) return;
    const Composition& composition = *model.composition;
    const hsize_t parts = composition.fields.parts.size();
    writePartFields(file, composition.fields);
    makeGroup(file, "/composition");
    writeIntegerAttribute(file, "/composition", "local_steps", composition.local_steps);
    writeIntegerAttribute(file, "/composition", "floor", composition.floor);
    writeIntegers(file, "/composition/part_of_vertex",
                  std::vector<std::int64_t>(composition.part_of_vertex.begin(), composition.part_of_vertex.end()),
                  {composition.part_of_vertex.size()}, H5T_STD_U16LE);
    writeIntegers(file, "/composition/steps",
                  std::vector<std::int64_t>(composition.steps.begin(), composition.steps.end()), {parts, parts},
                  H5T_STD_U8LE);
    writeNearParts(file, composition);
    makeGroup(file, "/residual");
    writeIntegerAttribute(file, "/residual", "count", std::int64_t(composition.residual.size()));
    writeNumberAttribute(file, "/residual", "worth", composition.residual_worth);
    for (std::size_t c = 0; c < composition.residual.size(); ++c)
        writeCluster(file, clusterGroup(c, "/residual"), composition.residual[c], std::size_t(model.convention.size()));
}

void writeIndirect(hid_t file, const Model& model) {
    if (!model.indirect) return;
    const IndirectModel& indirect = *model.indirect;
    makeGroup(file, "/indirect");
    writeIntegerAttribute(file, "/indirect", "count", std::int64_t(indirect.clusters.size()));
    writeIntegerAttribute(file, "/indirect", "bounces", indirect.bounces);
    writeNumberAttribute(file, "/indirect", "train_share", indirect.train_share);
    if (std::isfinite(indirect.holdout_share))
        writeNumberAttribute(file, "/indirect", "holdout_share", indirect.holdout_share);
    writeFloats(file, "/indirect/color_axes", indirect.axes.m, {3, 3});
    for (std::size_t c = 0; c < indirect.clusters.size(); ++c)
        writeCluster(file, clusterGroup(c, "/indirect"), indirect.clusters[c], kIndirectSize);
}

void writeModelRoot(hid_t file, const Model& model) {
    writeRoot(file, kModelFormat, model.convention.order, model.provenance);
    writeTextAttribute(file, "/", "convention", model.convention.name());
    writeTextAttribute(file, "/", "model", nameOf(model.kind));
    writeTextAttribute(file, "/", "features", nameOf(model.features));
    writeIntegerAttribute(file, "/", "deforming", model.deforming);
    writeNumberAttribute(file, "/", "feature_scale", model.feature_scale);
    writeNumberAttribute(file, "/", "input_variance", model.input_variance);
    writeNumberAttribute(file, "/", "output_variance", model.output_variance);
    writeStrings(file, "/clips/holdout", model.holdout_clips);
}

}  // namespace

void writeModel(const std::filesystem::path& path, const Model& model) {
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    const hsize_t frames = model.frames.frameCount(), joints = model.skin.jointCount();
    writeModelRoot(file, model);
    writeMesh(file, model.mesh, model.rest_normals);
    writeVectors(file, "/mesh/rest_tangents", model.rest_tangents);
    writeSkin(file, model.skin);
    if (model.drawn) writeDrawnMesh(file, *model.drawn);
    writeFrameList(file, model.frames);
    writeFloats(file, "/frames/bones", floatsOf(model.bones), {frames, joints, 3, 4});
    writeFloats(file, "/frames/pose", model.pose, {frames, hsize_t(model.pose_size)});
    writeModelInputs(file, model);
    writeDeforming(file, model);
    writeVectors(file, "/model/joint_centers", model.joint_centers);
    writeFloats(file, "/model/joint_spreads", floatsOf(model.joint_spreads), {joints, 3, 3});
    writeIndices(file, "/model/cluster_of_vertex", model.cluster_of_vertex);
    makeGroup(file, "/clusters");
    writeIntegerAttribute(file, "/clusters", "count", std::int64_t(model.clusters.size()));
    for (std::size_t c = 0; c < model.clusters.size(); ++c)
        writeCluster(file, clusterGroup(c), model.clusters[c], std::size_t(model.convention.size()));
    writeComposition(file, model);
    writeIndirect(file, model);
    writeClipErrors(file, model.clip_errors);
    closeHdf5(file);
    partial.commit();
}

// --- Reading --------------------------------------------------------------------------------------------------------

namespace {

// Lobes stand where a model is expected, but no run time evaluates them.
void refuseLobes(const Hdf5Reader& in) {
    if (readTextAttribute(in, "/", "format") == "penumbra.lobes")
        throw Unsupported(in.name +
                          ": zonal lobes are the reference model of zonal lobes, which penumbra-fit predict alone "
                          "evaluates; fit another kind");
}

void readModelRoot(const Hdf5Reader& in, Model& model) {
    const int order = readRoot(in, kModelFormat, model.provenance);
    const std::string convention = readTextAttribute(in, "/", "convention");
    try {
        model.convention = parseConvention(convention);
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(in.name + ": attribute convention: " + error.what());
    }
    if (model.convention.order != order)
        throw InvalidInput(in.name + ": attribute convention: " + convention + " is not of SH order " +
                           std::to_string(order));
    const std::string kind = readTextAttribute(in, "/", "model");
    const auto known = kindNamed(kModelKinds, kind);
    if (!known) throw Unsupported(in.name + ": attribute model: \"" + kind + "\" is unknown");
    model.kind = *known;
    const std::string features = readTextAttribute(in, "/", "features");
    const auto known_features = kindNamed(kFeatureKinds, features);
    if (!known_features) throw Unsupported(in.name + ": attribute features: \"" + features + "\" is unknown");
    model.features = *known_features;
    model.deforming = readIntegerAttribute(in, "/", "deforming", 0, 1) == 1;
    if (model.features == (model.deforming ? FeatureKind::kJointAngles : FeatureKind::kDihedrals))
        throw InvalidInput(in.name + ": attribute features: \"" + features + "\" of a mesh " +
                           (model.deforming ? "without joints" : "with a skeleton"));
    model.feature_scale = readNumberAttribute(in, "/", "feature_scale");
    if (model.feature_scale <= 0) throw InvalidInput(in.name + ": attribute feature_scale: is not positive");
    model.input_variance = readNumberAttribute(in, "/", "input_variance");
    model.output_variance = readNumberAttribute(in, "/", "output_variance");
    model.holdout_clips = readStrings(in, "/clips/holdout");
}

void readFrames(const Hdf5Reader& in, Model& model) {
    model.frames = readFrameList(in);
    std::vector<hsize_t> shape{model.frames.frameCount(), model.skin.jointCount(), 3, 4};
    const std::vector<float> bones = readFloats(in, "/frames/bones", shape);
    model.bones.resize(bones.size() / 12);
    std::copy(bones.begin(), bones.end(), floatsOf(model.bones).begin());
    shape = {model.frames.frameCount(), 0};
    model.pose = readFloats(in, "/frames/pose", shape);
    model.pose_size = int(shape[1]);
}

void checkRange(const Hdf5Reader& in, const std::string& dataset, const std::vector<float>& least,
                const std::vector<float>& most) {
    for (std::size_t i = 0; i < least.size(); ++i)
        if (least[i] > most[i]) throw InvalidInput(in.name + ": " + dataset + ": is above the other end of the range");
}

void readGroups(const Hdf5Reader& in, const std::string& name, const Model& model, ClusterModel& cluster) {
    cluster.groups = readIndices(in, name + "/groups", 0,
                                 groupCount(model.features, model.skin.jointCount(), std::size_t(model.pose_size)));
    const hsize_t groups = cluster.groups.size(), size = groups ? groupInputs(model.features) : 0;
    for (std::size_t g = 0; g < groups; ++g)
        if ((g > 0 && cluster.groups[g] <= cluster.groups[g - 1]) ||
            (model.features == FeatureKind::kRelativeBones && int(cluster.groups[g]) == cluster.joint))
            throw InvalidInput(in.name + ": " + name + "/groups: not ascending, or the cluster's own joint");
    cluster.group_weight = readExactly(in, name + "/group_weight", {groups});
    cluster.group_min = readExactly(in, name + "/group_min", {groups, size});
    cluster.group_max = readExactly(in, name + "/group_max", {groups, size});
    checkRange(in, name + "/group_min", cluster.group_min, cluster.group_max);
    const std::vector<float> center = readExactly(in, name + "/center", {3});
    cluster.center = {center[0], center[1], center[2]};
}

// Reads the weights [K, H] and the units. H follows from the kind of model, from /unit_group or from /hidden.
void readUnits(const Hdf5Reader& in, const std::string& name, const Model& model, ClusterModel& cluster) {
    const hsize_t components = cluster.components(), inputs = cluster.input_min.size();
    hsize_t units = inputs;
    std::vector<hsize_t> hidden{0, 0};
    cluster.unit_group = readIndices(in, name + "/unit_group", 0, cluster.groups.size());
    if (model.kind == ModelKind::kAdditive) {
        units = cluster.unit_group.size();
        hidden = {units, units ? groupInputs(model.features) : 0};
    } else if (!cluster.unit_group.empty()) {
        throw InvalidInput(in.name + ": " + name + "/unit_group: entries where none belong");
    }
    if (model.kind == ModelKind::kQuadratic) units = quadraticUnits(inputs);
    if (model.kind == ModelKind::kNeural) {
        cluster.hidden = readFloats(in, name + "/hidden", hidden);
        units = hidden[0];
        if (hidden[1] != (units ? inputs + 1 : 0))
            throw InvalidInput(in.name + ": " + name + "/hidden: a row is not the inputs and a bias");
    } else {
        cluster.hidden = readExactly(in, name + "/hidden", hidden);
    }
    cluster.weights = readExactly(in, name + "/weights", {components, units});
}

// `stride` counts the numbers of a vertex.
ClusterModel readCluster(const Hdf5Reader& in, const std::string& group, const Model& model, std::size_t stride) {
    ClusterModel cluster;
    const hsize_t raw = model.kind == ModelKind::kAdditive
                            ? 0
                            : featureCount(model.features, model.skin.jointCount(), std::size_t(model.pose_size));
    const std::size_t joints = model.skin.jointCount() - model.input_joints.size();  // an input carries no vertices
    cluster.joint = int(readIntegerAttribute(in, group, "joint", 0, std::int64_t(joints) - 1));
    cluster.vertices = readIndices(in, group + "/vertices", 0, model.mesh.vertexCount());
    const hsize_t vertices = cluster.vertices.size();
    cluster.feature_mean = readExactly(in, group + "/feature_mean", {raw});
    std::vector<hsize_t> shape{0};
    cluster.input_min = readFloats(in, group + "/input_min", shape);
    const hsize_t inputs = shape[0];
    cluster.input_max = readExactly(in, group + "/input_max", {inputs});
    cluster.input_basis = readExactly(in, group + "/input_basis", {inputs, raw});
    checkRange(in, group + "/input_min", cluster.input_min, cluster.input_max);
    readGroups(in, group, model, cluster);
    shape = {0};
    cluster.bias = readFloats(in, group + "/bias", shape);
    const hsize_t components = shape[0];
    readUnits(in, group, model, cluster);
    cluster.mean = readExactly(in, group + "/mean", {vertices, stride});
    cluster.basis = readExactly(in, group + "/basis", {components, vertices, stride});
    cluster.ridge = readNumberAttribute(in, group, "ridge");
    cluster.train_error = readNumberAttribute(in, group, "train_error");
    cluster.holdout_error = hasAttribute(in, group, "holdout_error") ? readNumberAttribute(in, group, "holdout_error")
                                                                     : std::numeric_limits<double>::quiet_NaN();
    return cluster;
}

// Checks that every vertex is in exactly one cluster, which must be the one that /model/cluster_of_vertex names.
void checkPartition(const Hdf5Reader& in, const Model& model) {
    std::vector<char> seen(model.mesh.vertexCount(), 0);
    std::size_t total = 0;
    for (std::size_t c = 0; c < model.clusters.size(); ++c)
        for (std::uint32_t v : model.clusters[c].vertices) {
            if (seen[v] || model.cluster_of_vertex[v] != c)
                throw InvalidInput(in.name + ": " + clusterGroup(c) + "/vertices: vertex " + std::to_string(v) +
                                   (seen[v] ? " is in two clusters" : " belongs to another cluster"));
            seen[v] = 1;
            ++total;
        }
    if (total != seen.size())
        throw InvalidInput(in.name + ": /clusters: hold " + std::to_string(total) + " of " +
                           std::to_string(seen.size()) + " vertices");
}

// Tells whether two lists have the same clusters: their joints and vertices.
bool sameClusters(const std::vector<ClusterModel>& a, const std::vector<ClusterModel>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ClusterModel& x, const ClusterModel& y) {
        return x.joint == y.joint && x.vertices == y.vertices;
    });
}

// Reads the near parts and their gains, if the model has any. A file has both datasets or none.
void readNearParts(const Hdf5Reader& in, Composition& composition) {
    const char *const parts_name = "/composition/near_parts", *const gains_name = "/composition/near_gains";
    const bool has_parts = exists(in, parts_name), has_gains = exists(in, gains_name);
    if (has_parts != has_gains)
        throw InvalidInput(in.name + ": " + (has_parts ? gains_name : parts_name) + ": is missing, but " +
                           (has_parts ? parts_name : gains_name) + " is there");
    if (!has_parts) return;
    const hsize_t parts = composition.fields.parts.size();
    std::vector<hsize_t> shape{parts, 0};
    const std::vector<std::int64_t> near_parts = readIntegers(in, parts_name, shape, 0, kNoPart);
    if (shape[1] < 1 || shape[1] > kMaxNear)
        throw InvalidInput(in.name + ": " + parts_name + ": has " + std::to_string(shape[1]) + " columns, not 1.." +
                           std::to_string(kMaxNear));
    composition.near_count = shape[1];
    composition.near_parts.assign(near_parts.begin(), near_parts.end());
    const std::string problem =
        findNearProblem(composition.near_parts, {composition.steps, parts, composition.local_steps});
    if (!problem.empty()) throw InvalidInput(in.name + ": " + parts_name + ": " + problem);
    shape = {composition.part_of_vertex.size(), composition.near_count};
    const std::vector<std::int64_t> gains = readIntegers(in, gains_name, shape, 0, 255);
    composition.near_gains.assign(gains.begin(), gains.end());
}

// Reads what makes the model a composed one, if anything does. The residual has the very vertices of the clusters.
void readComposition(const Hdf5Reader& in, Model& model) {
    if (!exists(in, "/composition")) return;
    if (model.convention.below != BelowHorizon::kMirrored)
        throw InvalidInput(in.name + ": /composition: not of convention D");
    Composition composition;
    composition.local_steps = int(readIntegerAttribute(in, "/composition", "local_steps", 0, 255));
    composition.floor = readIntegerAttribute(in, "/composition", "floor", 0, 1) == 1;
    const std::size_t inputs = model.input_joints.size();
    composition.fields = readPartFields(in, {model.skin.jointCount() - inputs, inputs, true});
    const hsize_t parts = composition.fields.parts.size();
    std::vector<hsize_t> shape{model.mesh.vertexCount()};
    const std::vector<std::int64_t> part =
        readIntegers(in, "/composition/part_of_vertex", shape, 0, std::int64_t(parts) - 1);
    composition.part_of_vertex.assign(part.begin(), part.end());
    shape = {parts, parts};
    const std::vector<std::int64_t> steps = readIntegers(in, "/composition/steps", shape, 0, 255);
    composition.steps.assign(steps.begin(), steps.end());
    readNearParts(in, composition);
    const auto count =
        std::size_t(readIntegerAttribute(in, "/residual", "count", 0, std::int64_t(model.clusters.size())));
    for (std::size_t c = 0; c < count; ++c)
        composition.residual.push_back(
            readCluster(in, clusterGroup(c, "/residual"), model, std::size_t(model.convention.size())));
    composition.residual_worth = readNumberAttribute(in, "/residual", "worth");
    if (!(composition.residual_worth >= 0 && composition.residual_worth <= 1))
        throw InvalidInput(in.name + ": /residual attribute worth: not in 0..1");
    if (count > 0 && !sameClusters(composition.residual, model.clusters))
        throw InvalidInput(in.name + ": /residual: its clusters are not those of /clusters");
    model.composition = std::move(composition);
}

void readIndirect(const Hdf5Reader& in, Model& model) {
    if (!exists(in, "/indirect")) return;
    IndirectModel indirect;
    indirect.bounces = int(readIntegerAttribute(in, "/indirect", "bounces", 1, kMaxBounces));
    indirect.train_share = readNumberAttribute(in, "/indirect", "train_share");
    indirect.holdout_share = hasAttribute(in, "/indirect", "holdout_share")
                                 ? readNumberAttribute(in, "/indirect", "holdout_share")
                                 : std::numeric_limits<double>::quiet_NaN();
    const std::vector<float> axes = readExactly(in, "/indirect/color_axes", {3, 3});
    std::copy(axes.begin(), axes.end(), indirect.axes.m.begin());
    const auto clusters = std::int64_t(model.clusters.size());
    const std::int64_t count = readIntegerAttribute(in, "/indirect", "count", clusters, clusters);
    for (std::int64_t c = 0; c < count; ++c)
        indirect.clusters.push_back(readCluster(in, clusterGroup(std::size_t(c), "/indirect"), model, kIndirectSize));
    if (!sameClusters(indirect.clusters, model.clusters))
        throw InvalidInput(in.name + ": /indirect: its clusters are not those of /clusters");
    model.indirect = std::move(indirect);
}

}  // namespace

Model readModel(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    refuseLobes(in);
    Model model;
    readModelRoot(in, model);
    model.mesh = readMesh(in);
    const std::size_t vertices = model.mesh.vertexCount();
    model.rest_normals = readVectors(in, "/mesh/rest_normals", vertices);
    model.rest_tangents = readVectors(in, "/mesh/rest_tangents", vertices);
    model.skin = readSkin(in, vertices);
    model.drawn = readDrawnMesh(in, model.mesh, model.skin);
    readFrames(in, model);
    readModelInputs(in, model);
    checkMorphInputs(in, model.mesh.morphs, model.input_names);
    readDeforming(in, model);
    model.joint_centers = readVectors(in, "/model/joint_centers", model.skin.jointCount());
    model.joint_spreads.resize(model.skin.jointCount());
    const std::vector<float> spreads = readExactly(in, "/model/joint_spreads", {model.skin.jointCount(), 3, 3});
    std::copy(spreads.begin(), spreads.end(), floatsOf(model.joint_spreads).begin());
    const std::int64_t clusters = readIntegerAttribute(in, "/clusters", "count", 1, std::int64_t(vertices));
    model.cluster_of_vertex = readIndices(in, "/model/cluster_of_vertex", vertices, std::size_t(clusters));
    for (std::int64_t c = 0; c < clusters; ++c)
        model.clusters.push_back(
            readCluster(in, clusterGroup(std::size_t(c)), model, std::size_t(model.convention.size())));
    checkPartition(in, model);
    readComposition(in, model);
    readIndirect(in, model);
    model.clip_errors = readClipErrors(in);
    return model;
}

}  // namespace penumbra
