#include "formats/stage/lobe_file.h"

#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/clip_errors.h"
#include "formats/stage/morphs_stored.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

std::size_t modelBytes(const LobeModel& model) {
    return sizeof(float) *
           (model.weights.size() + 3 * model.axes.size() + model.pose_basis.size() + model.pose_mean.size());
}

void writeLobes(const std::filesystem::path& path, const LobeModel& model) {
    const hsize_t vertices = model.mesh.vertexCount(), inputs = model.inputs(), lobes = model.lobes,
                  each = 2 + hsize_t(model.order);
    assert(model.axes.size() == vertices * lobes && model.weights.size() == vertices * (inputs + 1) * lobes * each);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kLobesFormat, model.order, model.provenance);
    writeNumberAttribute(file, "/", "input_variance", model.input_variance);
    writeNumberAttribute(file, "/", "ridge", model.ridge);
    writeMesh(file, model.mesh, model.rest_normals);
    writeVectors(file, "/mesh/rest_tangents", model.rest_tangents);
    writeSkin(file, model.skin);
    if (!model.input_names.empty()) writeStrings(file, "/inputs/names", model.input_names);
    writeStrings(file, "/clips/holdout", model.holdout_clips);
    writeIndices(file, "/lobes/cluster_of_vertex", model.cluster_of_vertex);
    writeIndices(file, "/lobes/joint_of_cluster",
                 std::vector<std::uint32_t>(model.joint_of_cluster.begin(), model.joint_of_cluster.end()));
    writeFloats(file, "/lobes/pose_mean", model.pose_mean, {model.pose_mean.size()});
    writeFloats(file, "/lobes/pose_basis", model.pose_basis, {inputs, model.pose_mean.size()});
    writeFloats(file, "/lobes/axes", floatsOf(model.axes), {vertices, lobes, 3});
    writeFloats(file, "/lobes/weights", model.weights, {vertices, inputs + 1, lobes, each});
    writeClipErrors(file, model.clip_errors);
    closeHdf5(file);
    partial.commit();
}

namespace {

void readLobesRoot(const Hdf5Reader& in, LobeModel& model) {
    model.order = readRoot(in, kLobesFormat, model.provenance);
    if (model.order < 2) throw InvalidInput(in.name + ": attribute sh_order: lobes have two bands or more");
    model.input_variance = readNumberAttribute(in, "/", "input_variance");
    if (!(model.input_variance > 0 && model.input_variance <= 1))
        throw InvalidInput(in.name + ": attribute input_variance: not in (0, 1]");
    model.ridge = readNumberAttribute(in, "/", "ridge");
    if (!(model.ridge >= 0)) throw InvalidInput(in.name + ": attribute ridge: not a number of 0 or more");
}

// Reads how a pose becomes inputs, and which joints carry the local frames.
void readPose(const Hdf5Reader& in, LobeModel& model) {
    const std::vector<std::uint32_t> joints = readIndices(in, "/lobes/joint_of_cluster", 0, model.skin.jointCount());
    model.joint_of_cluster.assign(joints.begin(), joints.end());
    model.cluster_of_vertex =
        readIndices(in, "/lobes/cluster_of_vertex", model.mesh.vertexCount(), model.joint_of_cluster.size());
    std::vector<hsize_t> shape{0};
    model.pose_mean = readFloats(in, "/lobes/pose_mean", shape);
    if (shape[0] == 0) throw InvalidInput(in.name + ": /lobes/pose_mean: empty");
    shape = {0, shape[0]};
    model.pose_basis = readFloats(in, "/lobes/pose_basis", shape);
    if (shape[0] == 0) throw InvalidInput(in.name + ": /lobes/pose_basis: empty");
}

void readAxes(const Hdf5Reader& in, LobeModel& model) {
    std::vector<hsize_t> shape{model.mesh.vertexCount(), 0, 3};
    const std::vector<float> axes = readFloats(in, "/lobes/axes", shape);
    model.lobes = shape[1];
    if (model.lobes < 1 || model.lobes > std::size_t(kMaxVisibilityLobes))
        throw InvalidInput(in.name + ": /lobes/axes: " + std::to_string(model.lobes) + " lobes, not 1.." +
                           std::to_string(kMaxVisibilityLobes));
    model.axes.resize(axes.size() / 3);
    std::copy(axes.begin(), axes.end(), floatsOf(model.axes).begin());
    for (const Vec3 axis : model.axes)
        if (!(std::abs(length(axis) - 1) < 1e-4f))
            throw InvalidInput(in.name + ": /lobes/axes: an axis is not of length 1");
}

}  // namespace

LobeModel readLobes(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    LobeModel model;
    readLobesRoot(in, model);
    model.mesh = readMesh(in);
    const std::size_t vertices = model.mesh.vertexCount();
    model.rest_normals = readVectors(in, "/mesh/rest_normals", vertices);
    model.rest_tangents = readVectors(in, "/mesh/rest_tangents", vertices);
    model.skin = readSkin(in, vertices);
    if (exists(in, "/inputs")) model.input_names = readStrings(in, "/inputs/names");
    checkMorphInputs(in, model.mesh.morphs, model.input_names);
    model.holdout_clips = readStrings(in, "/clips/holdout");
    readPose(in, model);
    readAxes(in, model);
    model.weights =
        readExactly(in, "/lobes/weights", {vertices, model.inputs() + 1, model.lobes, 2 + hsize_t(model.order)});
    model.clip_errors = readClipErrors(in);
    return model;
}

}  // namespace penumbra
