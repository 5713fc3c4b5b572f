#pragma once
// /shard of x.vis.h5 tells where the frames of a bake of some frames (--frames, --clips) stand among all frames. So
// `penumbra-bake merge` can tell what is missing without the rig.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct ShardPlace {
    std::vector<std::string> clip_names;       // all clips that could have been chosen, in the rig's order
    std::vector<std::uint32_t> clip_frames;    // how many sampled frames each of them has
    std::vector<std::uint32_t> frame_in_clip;  // [F] the number of each frame among the sampled frames of its clip

    // Returns an index into clip_names, or -1 when there is no such clip.
    int clipNamed(const std::string& name) const;
};

// Numbers the frames of each clip from 0.
std::vector<std::uint32_t> numberInClip(const FrameList& frames);

// Returns how many frames each clip of `frames` has.
std::vector<std::uint32_t> framesOfClips(const FrameList& frames);

// Writes ascending (clip, number) pairs as "'walk' 3:17, 'run' 0:5": at most `most` ranges, then "and 4 more".
struct ClipFrame {
    std::string clip;
    std::uint32_t number = 0;
};
std::string rangesText(const std::vector<ClipFrame>& frames, std::size_t most);

}  // namespace penumbra
