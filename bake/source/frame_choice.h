#pragma once
// Chooses the frames of a rig that a verb works on: slices of the sampled clips, and the lists of x.poses.h5.
#include <filesystem>
#include <string>
#include <vector>

#include "bake/common/bake_options.h"
#include "formats/rig/rig_poses.h"
#include "formats/stage/pose_file.h"

namespace penumbra {

// Throws BadOption when a file is given twice.
void refuseTwice(const std::vector<std::filesystem::path>& rigs);

// Returns the entries begin, begin + step, ... < end.
template <class T>
std::vector<T> slice(const std::vector<T>& all, const FrameRange& range) {
    std::vector<T> out;
    for (std::size_t i = range.begin; i<range.end; i = range.end - i> range.step ? i + range.step : range.end)
        out.push_back(all[i]);
    return out;
}

// Returns a slice of the list. Throws BadOption when the range ends beyond it.
FrameList sliceFrames(const FrameList& all, const FrameRange& range);

// Cuts every clip into contiguous blocks whose lengths differ by one at most. The blocks become clips "NAME#1",
// "NAME#2", ...; times stay. `blocks` 1 returns the list as it is. Throws BadOption for a clip of fewer frames than
// blocks, and when there would be more than 65535 clips.
FrameList cutIntoBlocks(const FrameList& frames, int blocks);
// Returns "NAME" for "NAME#3".
std::string clipOfBlock(const std::string& name);

// Adds the clips of `more` after those of `frames`. Throws BadOption for a clip that is in both.
void appendFrames(const FrameList& more, FrameList& frames);

// Returns for every name the index into rig.clips, or -1 (the rest pose) where the rig has no clip of this name.
std::vector<int> clipIndices(const Rig& rig, const std::vector<std::string>& names);
std::vector<RigFrame> rigFrames(const Rig& rig, const FrameList& frames);

// Throws BadOption, which lists the clips of `rig`, when it has none called `name`.
void checkClipName(const Rig& rig, const std::string& option, const std::string& name);

// Adds the sampled and the mixed poses of a list as clips of `rig`.
void addPoseClips(const PoseFile& poses, Rig& rig);

// Returns the frames that `path` lists. Sampled and mixed poses become clips of `rig`. Throws InvalidInput when the
// list does not fit the rig: it names clips, joints or nodes that the rig does not have, or times beyond the end of a
// clip.
FrameList readPoseFrames(const std::filesystem::path& path, Rig& rig);

}  // namespace penumbra
