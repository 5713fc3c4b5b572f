#pragma once
// The run-time evaluator against baked truth, in the terms of docs/formulas.md section 5.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset_file.h"
#include "formats/visibility_file.h"

namespace penumbra {

// Errors over a set of frames; NaN where there is nothing to divide by. Relative numbers are in units of
// sqrt(sum (y - mean y)^2), so that relative_error^2 = truncation^2 + regression^2.
struct ErrorFigures {
    std::string name;
    bool held_out = false;
    std::size_t frames = 0;
    double relative_error = 0, rms_v = 0, ambient_error = 0;
    double truncation = 0;             // the part of the truth outside the span of the stored mean and components
    double regression = 0;             // the rest: scores other than the best ones
    double prediction_difference = 0;  // of the evaluator to the predictions, relative; 0 without predictions
};

struct CheckResult {
    std::vector<ErrorFigures> clips;
    ErrorFigures training, held_out;  // frames = 0: there were none
    // Whether the mean of truth was taken over training frames of the truth; else it is the model's stored mean.
    bool mean_from_truth = false;
};

// InvalidInput when the mesh, skin, pose or order of a visibility file is not what the asset's model needs.
void checkFits(const AssetView& asset, const VisibilityHeader& header);

// Clips that the asset does not know count as held out. `predictions`, if any, must have every frame (clip and time) of
// the truth, else InvalidInput. Both must fit the asset. Deterministic for any number of threads.
CheckResult checkAsset(const AssetView& asset, const VisibilityReader& truth, const VisibilityReader* predictions,
                       int threads, const std::function<void(std::size_t)>& progress);

}  // namespace penumbra
