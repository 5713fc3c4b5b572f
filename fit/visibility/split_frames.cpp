#include "fit/visibility/split_frames.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/stage/pose_file.h"

namespace penumbra {

namespace {

void checkHoldout(const FrameList& frames, const std::vector<std::string>& holdout) {
    for (const std::string& name : holdout)
        if (std::find(frames.clip_names.begin(), frames.clip_names.end(), name) == frames.clip_names.end())
            throw BadOption("holdout", "no clip '" + name + "'; the file has " + listedNames(frames.clip_names));
}

// Returns which of `frames` are in `list`. Throws BadOption where a frame of the list is not among them or belongs to
// a clip that is held out.
std::vector<bool> listedFrames(const FrameList& frames, const FrameList& list,
                               const std::vector<std::string>& holdout) {
    std::vector<bool> listed(frames.frameCount());
    for (std::size_t i = 0; i < list.frameCount(); ++i) {
        const std::string& clip = list.clip_names[list.clip[i]];
        const std::string name = "clip '" + clip + "', " + std::to_string(list.time[i]) + " s: ";
        if (isHeldOut(holdout, clip)) throw BadOption("train_frames", name + "the clip is held out");
        std::size_t f = 0;
        while (f < listed.size() &&
               (frames.clip_names[frames.clip[f]] != clip || std::abs(frames.time[f] - list.time[i]) > kSameTime))
            ++f;
        if (f == listed.size()) throw BadOption("train_frames", name + "the visibility file has no such frame");
        listed[f] = true;
    }
    return listed;
}

}  // namespace

bool isHeldOut(const std::vector<std::string>& holdout, const std::string& clip) {
    return std::ranges::find(holdout, clip) != holdout.end();
}

bool isHeldOut(const std::vector<std::string>& holdout, const FrameList& frames, std::size_t frame) {
    return isHeldOut(holdout, frames.clip_names[frames.clip[frame]]);
}

Split splitFrames(const FrameList& frames, const std::vector<std::string>& holdout,
                  const std::optional<FrameList>& train_frames) {
    checkHoldout(frames, holdout);
    const std::vector<bool> listed =
        train_frames ? listedFrames(frames, *train_frames, holdout) : std::vector<bool>(frames.frameCount(), true);
    Split split;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        if (isHeldOut(holdout, frames, f))
            split.held_out.push_back(f);
        else if (listed[f])
            split.train.push_back(f);
    }
    if (split.train.empty()) throw BadOption("holdout", "no clip is left to train on");
    return split;
}

}  // namespace penumbra
