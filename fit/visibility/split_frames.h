#pragma once
// Splits the frames of a bake into those that a fit learns from and those that it is measured on.
#include <optional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

struct Split {
    std::vector<std::size_t> train, held_out;  // frames
};

// Tells whether a clip, or the clip of a frame, is held out.
bool isHeldOut(const std::vector<std::string>& holdout, const std::string& clip);
bool isHeldOut(const std::vector<std::string>& holdout, const FrameList& frames, std::size_t frame);

// Frames that `train_frames` does not list are neither, where it is set. Throws UsageError for a clip or a frame that
// the list of the bake lacks, and where no frame is left to train on.
Split splitFrames(const FrameList& frames, const std::vector<std::string>& holdout,
                  const std::optional<FrameList>& train_frames = {});

}  // namespace penumbra
