#include "formats/stage/transfer_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/morphs_stored.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

std::size_t paperBytes(const TransferModel& model) {
    if (model.kind == TransferModelKind::kLinear)
        return sizeof(float) * model.coefficients() * model.inputs() * model.outputs();
    return sizeof(float) * (model.basis.size() + model.weights.size() + model.pose_basis.size());
}

std::size_t paperMeshBytes(const TransferModel& model) {
    return sizeof(float) * model.coefficients() * model.mesh.vertexCount();
}

std::size_t modelBytes(const TransferModel& model) {
    return sizeof(float) * (model.basis.size() + model.weights.size() + model.pose_basis.size() + model.mean.size());
}

void writeTransfer(const std::filesystem::path& path, const TransferModel& model) {
    const hsize_t n = model.coefficients(), a = model.angles.size(), k = model.inputs(), m = model.outputs(),
                  vertices = model.mesh.vertexCount();
    assert(a > 0 && k > 0 && m > 0 && model.weights.size() == n * (k + 1) * m);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kTransferFormat, model.order, model.provenance);
    writeTextAttribute(file, "/", "model", nameOf(model.kind));
    writeNumberAttribute(file, "/", "alpha", model.alpha);
    writeIntegerAttribute(file, "/", "pose_size", model.pose_size);
    writeMesh(file, model.mesh, model.rest_normals);
    writeSkin(file, model.skin);
    const hsize_t frames = model.frames.frameCount();
    writeFrameList(file, model.frames);
    writeFloats(file, "/frames/bones", floatsOf(model.bones), {frames, model.skin.jointCount(), 3, 4});
    writeFloats(file, "/frames/pose", model.pose, {frames, hsize_t(model.pose_size)});
    if (!model.input_names.empty()) writeStrings(file, "/inputs/names", model.input_names);
    if (!model.holdout_clips.empty()) writeStrings(file, "/fit/holdout", model.holdout_clips);
    writeIndices(file, "/transfer/angles", model.angles);
    writeFloats(file, "/transfer/weights", model.weights, {n, k + 1, m});
    if (model.kind == TransferModelKind::kPca) {
        assert(model.mean.size() == vertices);
        writeFloats(file, "/transfer/pose_basis", model.pose_basis, {a, k});
        writeFloats(file, "/transfer/basis", model.basis, {m, vertices});
        writeFloats(file, "/transfer/mean", model.mean, {vertices});
    }
    closeHdf5(file);
    partial.commit();
}

namespace {

TransferModelKind readModelKind(const Hdf5Reader& in) {
    const std::string name = readTextAttribute(in, "/", "model");
    for (const TransferModelKind kind : kTransferModelKinds)
        if (name == nameOf(kind)) return kind;
    throw InvalidInput(in.name + ": attribute model: '" + name + "' is neither linear nor pca");
}

void readAngles(const Hdf5Reader& in, TransferModel& model) {
    model.pose_size = int(readIntegerAttribute(in, "/", "pose_size", 1, INT32_MAX));
    model.angles = readIndices(in, "/transfer/angles", 0, std::size_t(model.pose_size));
    if (model.angles.empty()) throw InvalidInput(in.name + ": /transfer/angles: empty");
    for (std::size_t i = 1; i < model.angles.size(); ++i)
        if (model.angles[i] <= model.angles[i - 1]) throw InvalidInput(in.name + ": /transfer/angles: not ascending");
}

void readFrames(const Hdf5Reader& in, TransferModel& model) {
    model.frames = readFrameList(in);
    const hsize_t frames = model.frames.frameCount();
    const std::vector<float> bones = readExactly(in, "/frames/bones", {frames, model.skin.jointCount(), 3, 4});
    model.bones.resize(bones.size() / 12);
    std::copy(bones.begin(), bones.end(), floatsOf(model.bones).begin());
    model.pose = readExactly(in, "/frames/pose", {frames, hsize_t(model.pose_size)});
}

// An axis of `dataset` that the others do not give must not be empty.
void checkNotEmpty(const Hdf5Reader& in, const char* dataset, hsize_t count) {
    if (count == 0) throw InvalidInput(in.name + ": " + dataset + ": empty");
}

}  // namespace

TransferModel readTransfer(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    TransferModel model;
    model.order = readRoot(in, kTransferFormat, model.provenance);
    model.kind = readModelKind(in);
    model.alpha = readNumberAttribute(in, "/", "alpha");
    if (!(std::isfinite(model.alpha) && model.alpha >= 0))
        throw InvalidInput(in.name + ": attribute alpha: not a number of 0 or more");
    model.mesh = readMesh(in);
    model.rest_normals = readVectors(in, "/mesh/rest_normals", model.mesh.vertexCount());
    model.skin = readSkin(in, model.mesh.vertexCount());
    if (exists(in, "/inputs")) model.input_names = readStrings(in, "/inputs/names");
    checkMorphInputs(in, model.mesh.morphs, model.input_names);
    if (exists(in, "/fit")) model.holdout_clips = readStrings(in, "/fit/holdout");
    readAngles(in, model);
    readFrames(in, model);
    const hsize_t n = model.coefficients(), a = model.angles.size(), vertices = model.mesh.vertexCount();
    hsize_t k = a, m = vertices;
    if (model.kind == TransferModelKind::kPca) {
        std::vector<hsize_t> pose_shape{a, 0}, basis_shape{0, vertices}, mean_shape{vertices};
        model.pose_basis = readFloats(in, "/transfer/pose_basis", pose_shape);
        model.basis = readFloats(in, "/transfer/basis", basis_shape);
        model.mean = readFloats(in, "/transfer/mean", mean_shape);
        k = pose_shape[1];
        m = basis_shape[0];
        checkNotEmpty(in, "/transfer/pose_basis", k);
        checkNotEmpty(in, "/transfer/basis", m);
    }
    std::vector<hsize_t> shape{n, k + 1, m};
    model.weights = readFloats(in, "/transfer/weights", shape);
    return model;
}

}  // namespace penumbra
