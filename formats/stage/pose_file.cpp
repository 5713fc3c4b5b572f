#include "formats/stage/pose_file.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

constexpr FileKind kPosesKind{"penumbra.poses", kPosesVersion};

void writePoseFile(const std::filesystem::path& path, const PoseFile& poses) {
    const std::size_t frames = poses.frames.frameCount(), joints = poses.joint_names.size();
    assert(poses.rank.size() == frames && poses.distance.size() == frames);
    assert(joints > 0 && poses.rotations.size() == poses.sampledCount() * 3 * joints);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeKind(file, kPosesKind, poses.provenance);
    writeFrameList(file, poses.frames);
    writeIndices(file, "/frames/rank", poses.rank);
    writeDoubles(file, "/frames/distance", poses.distance, {frames});
    writeStrings(file, "/skin/joint_names", poses.joint_names);
    if (poses.sampledCount() > 0) {
        writeFloats(file, "/sampled/pose", poses.rotations, {poses.sampledCount(), 3 * joints});
        writeTextAttribute(file, "/sampled/pose", "parameterisation", kJointRotationVectors);
    }
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

// Checks that the frames of the clip "sampled" stand at 0, 1, ... seconds, one for each row of /sampled/pose.
void checkSampled(const Hdf5Reader& in, const PoseFile& poses) {
    std::size_t rows = 0;
    for (std::size_t f = 0; f < poses.frames.frameCount(); ++f) {
        if (poses.frames.clip_names[poses.frames.clip[f]] != kSampledClip) continue;
        if (poses.frames.time[f] != double(rows++))
            throw InvalidInput(in.name + ": /frames/time: sampled pose " + std::to_string(rows - 1) + " is not at " +
                               std::to_string(rows - 1) + " s");
    }
    if (rows != poses.sampledCount())
        throw InvalidInput(in.name + ": /sampled/pose: " + std::to_string(poses.sampledCount()) + " rows for " +
                           std::to_string(rows) + " frames of clip 'sampled'");
}

}  // namespace

PoseFile readPoseFile(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    PoseFile poses;
    readKind(in, kPosesKind, poses.provenance);
    poses.frames = readFrameList(in);
    const std::size_t frames = poses.frames.frameCount();
    poses.rank = readIndices(in, "/frames/rank", frames, frames);
    std::vector<hsize_t> shape{frames};
    poses.distance = readDoubles(in, "/frames/distance", shape);
    poses.joint_names = readStrings(in, "/skin/joint_names");
    if (poses.joint_names.empty() || poses.joint_names.size() > 65535)
        throw InvalidInput(in.name + ": /skin/joint_names: " + std::to_string(poses.joint_names.size()) + " joints");
    checkUnique(in, "/skin/joint_names", poses.joint_names);
    if (exists(in, "/sampled/pose")) {
        const std::string found = readTextAttribute(in, "/sampled/pose", "parameterisation");
        if (found != kJointRotationVectors)
            throw InvalidInput(in.name + ": /sampled/pose parameterisation: '" + found + "', not '" +
                               kJointRotationVectors + "'");
        shape = {0, 3 * poses.joint_names.size()};
        poses.rotations = readFloats(in, "/sampled/pose", shape);
    }
    checkFrames(in, poses);
    checkSampled(in, poses);
    return poses;
}

}  // namespace penumbra
