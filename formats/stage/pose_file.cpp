#include "formats/stage/pose_file.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

constexpr const char* kNodeTransforms = "node_transforms";

static void writeWeights(hid_t file, const PoseFile& poses) {
    if (poses.weight_names.empty()) return;
    const std::size_t width = poses.weight_names.size();
    assert(poses.sampled_weights.size() == poses.sampledCount() * width);
    assert(poses.mixed_weights.size() == poses.mixedCount() * width);
    writeStrings(file, "/weights/names", poses.weight_names);
    if (poses.sampledCount() > 0)
        writeFloats(file, "/weights/sampled", poses.sampled_weights, {poses.sampledCount(), width});
    if (poses.mixedCount() > 0) writeFloats(file, "/weights/mixed", poses.mixed_weights, {poses.mixedCount(), width});
}

void writePoseFile(const std::filesystem::path& path, const PoseFile& poses) {
    const std::size_t frames = poses.frames.frameCount(), joints = poses.joint_names.size();
    assert(poses.rank.size() == frames && poses.distance.size() == frames);
    assert(joints > 0 && poses.rotations.size() == poses.sampledCount() * 3 * joints);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeKind(file, kPosesFormat, poses.provenance);
    writeFrameList(file, poses.frames);
    writeIndices(file, "/frames/rank", poses.rank);
    writeDoubles(file, "/frames/distance", poses.distance, {frames});
    writeStrings(file, "/skin/joint_names", poses.joint_names);
    if (poses.sampledCount() > 0) {
        writeFloats(file, "/sampled/pose", poses.rotations, {poses.sampledCount(), 3 * joints});
        writeTextAttribute(file, "/sampled/pose", "parameterisation", kJointRotationVectors);
    }
    if (poses.mixedCount() > 0) {
        assert(poses.mixed.size() == poses.mixedCount() * kMixedValues * poses.node_names.size());
        writeStrings(file, "/mixed/node_names", poses.node_names);
        writeFloats(file, "/mixed/nodes", poses.mixed, {poses.mixedCount(), poses.node_names.size(), kMixedValues});
        writeTextAttribute(file, "/mixed/nodes", "parameterisation", kNodeTransforms);
    }
    writeWeights(file, poses);
    closeHdf5(file);
    partial.commit();
}

namespace {

void checkFrames(const Hdf5Reader& in, const PoseFile& poses) {
    const std::size_t frames = poses.frames.frameCount();
    std::vector<char> seen(frames, 0);
    for (const std::uint32_t rank : poses.rank)
        if (std::exchange(seen[rank], 1)) throw InvalidInput(in.name + ": /frames/rank: not a permutation");
    for (const double d : poses.distance)
        if (d < 0) throw InvalidInput(in.name + ": /frames/distance: negative");
    for (std::size_t c = 0, f = 0; c < poses.frames.clip_names.size(); ++c) {
        if (f == frames || poses.frames.clip[f] != c)
            throw InvalidInput(in.name + ": /clips/names: clip '" + poses.frames.clip_names[c] + "' has no frame");
        for (; f < frames && poses.frames.clip[f] == c; ++f)
            if (poses.frames.time[f] < 0 || (f > 0 && poses.frames.clip[f - 1] == c &&
                                             !(poses.frames.time[f] - poses.frames.time[f - 1] > kSameTime)))
                throw InvalidInput(in.name + ": /frames/time: frame " + std::to_string(f) +
                                   " is not after the one before");
    }
}

// Checks that the frames of the clip "sampled" or "mixed" stand at 0, 1, ... seconds, one for each of the `count` rows
// of `dataset`.
void checkMadePoses(const Hdf5Reader& in, const PoseFile& poses, const std::string& clip, const std::string& dataset,
                    std::size_t count) {
    std::size_t rows = 0;
    for (std::size_t f = 0; f < poses.frames.frameCount(); ++f) {
        if (poses.frames.clip_names[poses.frames.clip[f]] != clip) continue;
        if (poses.frames.time[f] != double(rows++))
            throw InvalidInput(in.name + ": /frames/time: " + clip + " pose " + std::to_string(rows - 1) +
                               " is not at " + std::to_string(rows - 1) + " s");
    }
    if (rows != count)
        throw InvalidInput(in.name + ": " + dataset + ": " + std::to_string(count) + " rows for " +
                           std::to_string(rows) + " frames of clip '" + clip + "'");
}

void checkParameterisation(const Hdf5Reader& in, const std::string& dataset, const std::string& expected) {
    const std::string found = readTextAttribute(in, dataset, "parameterisation");
    if (found != expected)
        throw InvalidInput(in.name + ": " + dataset + " parameterisation: '" + found + "', not '" + expected + "'");
}

void readSampled(const Hdf5Reader& in, PoseFile& poses) {
    if (!exists(in, "/sampled/pose")) return;
    checkParameterisation(in, "/sampled/pose", kJointRotationVectors);
    std::vector<hsize_t> shape{0, 3 * poses.joint_names.size()};
    poses.rotations = readFloats(in, "/sampled/pose", shape);
}

void readMixed(const Hdf5Reader& in, PoseFile& poses) {
    if (!exists(in, "/mixed/nodes")) return;
    checkParameterisation(in, "/mixed/nodes", kNodeTransforms);
    poses.node_names = readStrings(in, "/mixed/node_names");
    if (poses.node_names.empty()) throw InvalidInput(in.name + ": /mixed/node_names: no nodes");
    std::vector<hsize_t> shape{0, poses.node_names.size(), kMixedValues};
    poses.mixed = readFloats(in, "/mixed/nodes", shape);
    for (std::size_t row = 0; row < poses.mixed.size(); row += kMixedValues) {
        double squared = 0;
        for (std::size_t i = 3; i < 7; ++i) squared += double(poses.mixed[row + i]) * poses.mixed[row + i];
        if (!(std::abs(squared - 1) <= 1e-3))
            throw InvalidInput(in.name + ": /mixed/nodes: the quaternion of pose " +
                               std::to_string(row / kMixedValues / poses.node_names.size()) + ", node '" +
                               poses.node_names[row / kMixedValues % poses.node_names.size()] + "', is not unit");
    }
}

void readWeights(const Hdf5Reader& in, PoseFile& poses) {
    if (!exists(in, "/weights/names")) return;
    poses.weight_names = readStrings(in, "/weights/names");
    if (poses.weight_names.empty() || poses.weight_names.size() > 65535)
        throw InvalidInput(in.name + ": /weights/names: " + std::to_string(poses.weight_names.size()) + " names");
    const hsize_t width = poses.weight_names.size();
    if (poses.sampledCount() > 0)
        poses.sampled_weights = readExactly(in, "/weights/sampled", {poses.sampledCount(), width});
    if (poses.mixedCount() > 0) poses.mixed_weights = readExactly(in, "/weights/mixed", {poses.mixedCount(), width});
}

}  // namespace

PoseFile readPoseFile(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    PoseFile poses;
    readKind(in, kPosesFormat, poses.provenance);
    poses.frames = readFrameList(in);
    const std::size_t frames = poses.frames.frameCount();
    poses.rank = readIndices(in, "/frames/rank", frames, frames);
    std::vector<hsize_t> shape{frames};
    poses.distance = readDoubles(in, "/frames/distance", shape);
    poses.joint_names = readStrings(in, "/skin/joint_names");
    if (poses.joint_names.empty() || poses.joint_names.size() > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(poses.joint_names.size()) + " joints");
    checkUnique(in, "/skin/joint_names", poses.joint_names);
    readSampled(in, poses);
    readMixed(in, poses);
    readWeights(in, poses);
    checkFrames(in, poses);
    checkMadePoses(in, poses, kSampledClip, "/sampled/pose", poses.sampledCount());
    checkMadePoses(in, poses, kMixedClip, "/mixed/nodes", poses.mixedCount());
    return poses;
}

}  // namespace penumbra
