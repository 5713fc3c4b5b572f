#pragma once
// Which frames of a rig a verb works on: slices of the sampled clips, and the lists of x.poses.h5.
#include <filesystem>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "formats/rig/rig_poses.h"

namespace penumbra {

// UsageError when a file is given twice.
void refuseTwice(const std::vector<std::filesystem::path>& rigs);

// Entries begin, begin + step, ... < end.
template <class T>
std::vector<T> slice(const std::vector<T>& all, const FrameRange& range) {
    std::vector<T> out;
    for (std::size_t i = range.begin; i<range.end; i = range.end - i> range.step ? i + range.step : range.end)
        out.push_back(all[i]);
    return out;
}

// UsageError when the range ends beyond the list.
FrameList sliceFrames(const FrameList& all, const FrameRange& range);

// Every clip cut into contiguous blocks whose lengths differ by one at most, which become clips "NAME#1", "NAME#2",
// ...; times stay. `blocks` 1: the list as it is. UsageError for a clip of fewer frames, and when there would be too
// many clips.
FrameList cutIntoBlocks(const FrameList& frames, int blocks);
// "NAME" of "NAME#3".
std::string clipOfBlock(const std::string& name);

// Adds the clips of `more` behind those of `frames`. UsageError for a clip that is in both.
void appendFrames(const FrameList& more, FrameList& frames);

// Index into rig.clips of every name; -1 (the rest pose) for a name that the rig does not have.
std::vector<int> clipIndices(const Rig& rig, const std::vector<std::string>& names);
std::vector<RigFrame> rigFrames(const Rig& rig, const FrameList& frames);

// UsageError that lists the clips of `rig` when it has none called `name`.
void checkClipName(const Rig& rig, const std::string& option, const std::string& name);

// The frames that `path` lists; the sampled ones become a clip of `rig`. InvalidInput when the list does not go with
// the rig: clips or joints that it does not have, times beyond the end of a clip.
FrameList readPoseFrames(const std::filesystem::path& path, Rig& rig);

}  // namespace penumbra
