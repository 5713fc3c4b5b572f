#pragma once
// `penumbra-bake poses --auto`: chooses the kinds and the number of made poses by trial fits.
#include <cstdint>
#include <filesystem>
#include <vector>

#include "bake/pilot/pose_kinds.h"
#include "bake/poses/pose_list.h"
#include "formats/common/progress.h"

namespace penumbra {

struct AutoOptions {
    PoseCounts most = {200, 300, 300};  // poses of each kind that a list may get, >= 1
    double minutes = 0;                 // that the later bake may take on this machine, > 0; 0: any
    int rays = 1024;                    // of the later bake, 16..2^16
};

struct AutoTrial {
    PoseTrial trial;
    TrialRatio ratio;    // to the clips alone
    double minutes = 0;  // of the bake of the list
};

struct AutoChoice {
    std::vector<AutoTrial> tried;  // the clips alone first; empty where they alone take longer than the minutes
    std::size_t chosen = 0;
    double clip_minutes = 0;                  // of the bake of the clips alone
    double pilot_minutes = 0;                 // that the choice took
    std::size_t pilot_frames = 0, folds = 0;  // of the pilot
    bool composed = false;                    // its fits were, else additive
    bool can_mix = true;

    PoseCounts counts() const { return tried.empty() ? PoseCounts{} : tried[chosen].trial.counts; }
};

// The rig, its frames and how they are read, for which the choice is made.
struct AutoInput {
    const std::vector<std::filesystem::path>& rigs;
    const PosePlan& plan;
    const PoseOptions& options;  // its numbers are not used
};

// Chooses by the trials of pose_pilot.h: first among the kinds, with as many poses as the minutes allow, then whether
// half of the poses are as good. The minutes are those of estimateBake() for the frames of the clips, in proportion to
// the number of poses. The choice depends on the files, the options and the seed alone; where there are minutes, also
// on how fast this machine is. Throws as PosePilot does.
AutoChoice chooseAutoPoses(const AutoInput& input, const AutoOptions& wanted, int threads, ProgressStyle progress);

}  // namespace penumbra
