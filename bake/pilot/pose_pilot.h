#pragma once
// The pilot of `penumbra-bake poses --auto`: small bakes and fits that tell what made poses do for clips that a fit has
// not seen.
//
// The candidate frames are dealt out to folds, clip by clip. For each fold, poses are made from the frames of all other
// folds, so nothing of the fold enters them. They are baked with few rays at few points, together with the frames of
// the clips, and penumbra-fit trains on each combination of kinds. The error is that of the visibility on the fold's
// frames (rms of V), which needs no mean, so errors of all combinations compare.
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "bake/pilot/pose_kinds.h"
#include "bake/poses/pose_list.h"
#include "formats/common/temporary_folder.h"

namespace penumbra {

struct PilotOptions {
    // A trial of many frames takes long: the units of a fit are chosen in time that grows with frames and clusters.
    std::size_t frames = 160;        // at most so many candidate frames, evenly spread
    std::size_t folds = 4;           // at most so many
    int points = 500;                // of the surface
    int rays = 128;                  // above the horizon
    int clusters = 12;               // of the fits
    PoseCounts made = {60, 90, 90};  // poses of each kind; 0: it is not tried
};

struct PilotInput {
    const std::vector<std::filesystem::path>& rigs;
    const PosePlan& plan;
    const PoseOptions& options;  // seed, limits and how the rig is read; its numbers are not used
    int threads = 0;
    std::function<void()> step = {};  // called after each bake and each fit
};

class PosePilot {
public:
    // Finds penumbra-fit, deals the frames out and makes the fields of the rig's parts, if it has several: then fits
    // are composed, else additive. Throws BadOption where there is no penumbra-fit or there are too few frames.
    PosePilot(const PilotInput& input, const PilotOptions& options);

    // Tells whether poses can be mixed from the frames of each fold's training clips.
    bool canMix() const;

    // Makes the poses of each fold, bakes them, and returns the error of each of `kinds` in each fold, [kinds][folds].
    // A kind has at most the poses of the options, and gets the first ones of these. Throws std::runtime_error where a
    // fit fails, and Interrupted.
    std::vector<std::vector<double>> errorsOf(std::span<const PoseCounts> kinds) const;

    std::size_t folds() const { return folds_; }
    std::size_t frames() const { return frames_.frameCount(); }
    bool composed() const { return !fields_.empty(); }
    void setMade(const PoseCounts& made) { options_.made = made; }

private:
    PilotInput input_;
    PilotOptions options_;
    std::filesystem::path fit_;  // the program
    FrameList frames_;
    std::vector<int> fold_of_frame_;
    std::size_t folds_ = 0;
    TemporaryFolder folder_;
    std::filesystem::path fields_;  // "" for additive fits

    PosePlan planWithout(int fold) const;
    FrameList bakeFold(int fold, const std::filesystem::path& output) const;
    double errorOf(int fold, const FrameList& baked, const PoseCounts& kind) const;
};

}  // namespace penumbra
