#include "bake/source/frame_choice.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/rig/rig_morphs.h"

namespace penumbra {

void refuseTwice(const std::vector<std::filesystem::path>& rigs) {
    for (std::size_t i = 0; i < rigs.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            std::error_code missing;  // readRig() reports a missing file
            if (rigs[i] == rigs[j] || std::filesystem::equivalent(rigs[i], rigs[j], missing))
                throw BadOption("rig", rigs[i].string() + " is given twice");
        }
}

FrameList sliceFrames(const FrameList& all, const FrameRange& range) {
    checkFrameRange(range, all.frameCount());
    return {all.clip_names, slice(all.clip, range), slice(all.time, range)};
}

FrameList cutIntoBlocks(const FrameList& frames, int blocks) {
    if (blocks == 1) return frames;
    FrameList out{{}, {}, frames.time};
    const std::vector<std::uint32_t> counts = framesOfClips(frames);
    for (std::size_t c = 0; c < counts.size(); ++c) {
        const auto count = std::uint64_t(blocks);
        if (count > counts[c])
            throw BadOption("blocks", "must be at most " + std::to_string(counts[c]) + ", the frames of clip '" +
                                          frames.clip_names[c] + "', not " + std::to_string(blocks));
        for (std::uint64_t b = 0; b < count; ++b) {
            const std::uint64_t begin = b * counts[c] / count, end = (b + 1) * counts[c] / count;
            out.clip.insert(out.clip.end(), end - begin, std::uint16_t(out.clip_names.size()));
            out.clip_names.push_back(frames.clip_names[c] + "#" + std::to_string(b + 1));
        }
        if (out.clip_names.size() > 65535) throw BadOption("blocks", "would make more than 65535 clips");
    }
    return out;
}

std::string clipOfBlock(const std::string& name) { return name.substr(0, name.rfind('#')); }

void appendFrames(const FrameList& more, FrameList& frames) {
    for (const std::string& name : more.clip_names)
        if (std::find(frames.clip_names.begin(), frames.clip_names.end(), name) != frames.clip_names.end())
            throw BadOption("clips", "the list of poses has frames of clip '" + name + "' already");
    const std::size_t clips = frames.clip_names.size();
    if (clips + more.clip_names.size() > 65535)
        throw BadOption("clips", "more than 65535 clips with those of the list of poses");
    frames.clip_names.insert(frames.clip_names.end(), more.clip_names.begin(), more.clip_names.end());
    for (const std::uint16_t clip : more.clip) frames.clip.push_back(std::uint16_t(clip + clips));
    frames.time.insert(frames.time.end(), more.time.begin(), more.time.end());
}

std::vector<int> clipIndices(const Rig& rig, const std::vector<std::string>& names) {
    std::vector<int> indices;
    for (const std::string& name : names) {
        const auto found =
            std::find_if(rig.clips.begin(), rig.clips.end(), [&](const Clip& clip) { return clip.name == name; });
        indices.push_back(found == rig.clips.end() ? -1 : int(found - rig.clips.begin()));
    }
    return indices;
}

std::vector<RigFrame> rigFrames(const Rig& rig, const FrameList& frames) {
    const std::vector<int> clips = clipIndices(rig, frames.clip_names);
    std::vector<RigFrame> out;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) out.push_back({clips[frames.clip[f]], frames.time[f]});
    return out;
}

void checkClipName(const Rig& rig, const std::string& option, const std::string& name) {
    std::vector<std::string> known;
    for (const Clip& clip : rig.clips) {
        if (clip.name == name) return;
        known.push_back(clip.name);
    }
    throw BadOption(option, "no clip '" + name + "'; the rig has " + listedNames(known));
}

namespace {

// Checks that the rig has the clips, times and joints that a list of poses names.
void checkPoses(const std::filesystem::path& path, const PoseFile& poses, const Rig& rig) {
    const std::vector<int> clips = clipIndices(rig, poses.frames.clip_names);
    const auto fail = [&](const std::string& what) { throw InvalidInput(path.string() + ": " + what); };
    for (std::size_t c = 0; c < clips.size(); ++c) {
        const std::string& name = poses.frames.clip_names[c];
        const bool made = name == kSampledClip || name == kMixedClip;
        if (made && clips[c] >= 0) fail("/clips/names: '" + name + "' is a clip of the rig as well; rename that one");
        if (clips[c] < 0 && !made && !(rig.clips.empty() && name == kRestClip))
            fail("/clips/names: the rig has no clip '" + name + "'");
    }
    for (std::size_t f = 0; f < poses.frames.frameCount(); ++f)
        if (const int clip = clips[poses.frames.clip[f]];
            clip >= 0 && poses.frames.time[f] > rig.clips[std::size_t(clip)].duration + kSameTime)
            fail("/frames/time: " + std::to_string(poses.frames.time[f]) + " s is beyond the end of clip '" +
                 rig.clips[std::size_t(clip)].name + "'");
    if (poses.sampledCount() > 0 && poses.joint_names != rig.skin.joint_names)
        fail("/skin/joint_names: sampled poses of a rig with other joints");
    const auto same_name = [](const Node& node, const std::string& name) { return node.name == name; };
    if (poses.mixedCount() > 0 &&
        !std::equal(rig.nodes.begin(), rig.nodes.end(), poses.node_names.begin(), poses.node_names.end(), same_name))
        fail("/mixed/node_names: mixed poses of a rig with other nodes");
    if (poses.sampledCount() + poses.mixedCount() > 0 && poses.weight_names != rig.mesh.morphs.names)
        fail("/weights/names: poses of a rig with other morph targets");
}

}  // namespace

void addPoseClips(const PoseFile& poses, Rig& rig) {
    static_assert(kMixedValues == kNodeValues);
    if (poses.sampledCount() > 0) {
        rig.clips.push_back(clipOfRotations(rig, poses.rotations, kSampledClip));
        addWeightKeys(int(rig.clips.size()) - 1, poses.sampled_weights, rig);
    }
    if (poses.mixedCount() > 0) {
        rig.clips.push_back(clipOfNodes(rig, poses.mixed, kMixedClip));
        addWeightKeys(int(rig.clips.size()) - 1, poses.mixed_weights, rig);
    }
}

FrameList readPoseFrames(const std::filesystem::path& path, Rig& rig) {
    const PoseFile poses = readPoseFile(path);
    checkPoses(path, poses, rig);
    addPoseClips(poses, rig);
    return poses.frames;
}

}  // namespace penumbra
