#include "formats/stage/model_deforming.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

void writeModelInputs(hid_t file, const Model& model) {
    if (model.input_names.empty()) return;
    writeStrings(file, "/inputs/names", model.input_names);
    std::vector<std::int64_t> columns;
    std::vector<float> scales;
    for (const InputJoint& input : model.input_joints) {
        columns.insert(columns.end(), {input.joint, input.column, input.columns});
        scales.insert(scales.end(), {input.offset, input.scale});
    }
    const hsize_t count = model.input_joints.size();
    writeIntegers(file, "/inputs/joints", columns, {count, 3}, H5T_STD_U32LE);
    writeFloats(file, "/inputs/scales", scales, {count, 2});
}

void writeDeforming(hid_t file, const Model& model) {
    if (!model.deforming) return;
    writeFloats(file, "/frames/positions", floatsOf(model.positions),
                {model.frames.frameCount(), model.mesh.frontVertexCount(), 3});
    if (model.features != FeatureKind::kDihedrals) return;
    const hsize_t reduced = hsize_t(model.pose_size) - model.input_names.size();
    writeFloats(file, "/model/pose_mean", model.pose_mean, {model.pose_mean.size()});
    writeFloats(file, "/model/pose_basis", model.pose_basis, {reduced, model.pose_mean.size()});
}

void readModelInputs(const Hdf5Reader& in, Model& model) {
    if (!exists(in, "/inputs")) return;
    model.input_names = readStrings(in, "/inputs/names");
    checkUnique(in, "/inputs/names", model.input_names);
    if (model.input_names.size() > std::size_t(model.pose_size))
        throw InvalidInput(in.name + ": /inputs/names: more than /frames/pose has numbers");
    std::vector<hsize_t> shape{0, 3};
    const std::vector<std::int64_t> columns = readIntegers(in, "/inputs/joints", shape, 0, UINT32_MAX);
    const std::vector<float> scales = readExactly(in, "/inputs/scales", {shape[0], 2});
    for (std::size_t i = 0; i < shape[0]; ++i) {
        const InputJoint joint{std::uint32_t(columns[3 * i]), std::uint32_t(columns[3 * i + 1]),
                               std::uint32_t(columns[3 * i + 2]), scales[2 * i], scales[2 * i + 1]};
        if ((joint.columns != 1 && joint.columns != 3) || joint.joint + shape[0] != model.skin.jointCount() + i ||
            joint.column + std::size_t(joint.columns) > model.input_names.size())
            throw InvalidInput(in.name + ": /inputs/joints: row " + std::to_string(i) +
                               " is not of one or three inputs and of its place among the last joints");
        model.input_joints.push_back(joint);
    }
}

namespace {

// Checks that a vertex of a deforming mesh follows one part, which is no input, and a back the part of its front.
void checkParts(const Hdf5Reader& in, const Model& model) {
    if (model.skin.influences != 1)
        throw InvalidInput(in.name + ": /skin/joints: " + std::to_string(model.skin.influences) +
                           " influences of a deforming mesh, not 1");
    std::vector<bool> is_input(model.skin.jointCount());
    for (const InputJoint& input : model.input_joints) is_input[input.joint] = true;
    const std::size_t fronts = model.mesh.frontVertexCount();
    for (std::size_t v = 0; v < model.skin.joints.size(); ++v)
        if (is_input[model.skin.joints[v]] || model.skin.joints[v] != model.skin.joints[v % fronts])
            throw InvalidInput(in.name + ": /skin/joints: vertex " + std::to_string(v) +
                               " follows an input, or another part than its front");
}

}  // namespace

void readDeforming(const Hdf5Reader& in, Model& model) {
    if (!model.deforming) return;
    checkParts(in, model);
    const hsize_t frames = model.frames.frameCount(), vertices = model.mesh.frontVertexCount();
    const std::vector<float> positions = readExactly(in, "/frames/positions", {frames, vertices, 3});
    model.positions.resize(positions.size() / 3);
    std::copy(positions.begin(), positions.end(), floatsOf(model.positions).begin());
    if (model.features != FeatureKind::kDihedrals) return;
    std::vector<hsize_t> shape{0};
    model.pose_mean = readFloats(in, "/model/pose_mean", shape);
    const hsize_t reduced = hsize_t(model.pose_size) - model.input_names.size();
    model.pose_basis = readExactly(in, "/model/pose_basis", {reduced, shape[0]});
}

}  // namespace penumbra
