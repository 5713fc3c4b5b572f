#pragma once
// Compares the run-time evaluator with baked truth, in the terms of docs/formulas.md, section 5.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/stage/visibility_file.h"
#include "pack/check/worst_pairs.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

// Errors over a set of frames; NaN where there is nothing to divide by, or where an error was not measured. Relative
// numbers are in units of sqrt(sum (y - mean y)^2), so that relative_error^2 = truncation^2 + regression^2. Times
// signal_rms_v they are rms V.
struct ErrorFigures {
    std::string name;
    bool held_out = false;
    std::size_t frames = 0;
    double relative_error = 0, rms_v = 0, ambient_error = 0;
    // The bound that 99.9% of the errors of E over (vertex, frame) pairs stay below, to 1 / ErrorTail::kBins, and the
    // largest error.
    double ambient_p999 = 0, ambient_max = 0;
    double truncation = 0;  // the part of the truth outside the span of the stored mean and components; NaN if composed
    double regression = 0;  // the rest: scores that are not the best ones; NaN if composed
    // difference of the evaluator and the predictions, relative; 0 without predictions
    double prediction_difference = 0;
    double signal_rms_v = 0;   // rms V of y - mean y
    double sh_truncation = 0;  // the part of visibility outside the bands of the convention, if it is 0 or 1 everywhere
    double bake_noise = 0;     // noise of the truth: its difference to the second bake / sqrt 2
    // The error of the unpacked model, the part of the truth outside the span of its components, and the difference
    // between its numbers and the packed ones.
    double unpacked_error = 0, unpacked_truncation = 0, packing = 0;
    // Composed models have these instead of truncation and regression; of others they are NaN.
    bool composed = false;
    // All but `split` are of the unpacked model if it was given. Those of the truth's local visibility are NaN if the
    // truth has none.
    double without_residual = 0;  // the error of local visibility x far parts alone
    double split = 0;             // the error of the truth's local visibility x far parts
    // The same of a sample, with the parts by their fields and by rays (formats/common/far_by_rays.h), relative to what
    // all vertices and frames vary.
    double far_by_fields = 0, far_by_rays = 0;
    std::size_t far_frames = 0;   // frames in the sample
    double local = 0;             // the difference of these two products: what the local model costs
    double local_truncation = 0;  // the part that comes from moving the true local visibility into the span of the
                                  // stored mean and components
    double local_regression = 0;  // the rest: from there to the model's local visibility
};

// A frame of the truth: its error, beside what the evaluator itself can tell about the pose.
struct FrameCheck {
    std::string clip;
    double time = 0;  // seconds
    bool held_out = false;
    double rms_v = 0, out_of_range = 0;  // out_of_range: Evaluator::outOfRange()
};

struct CheckResult {
    std::vector<ErrorFigures> clips;
    std::vector<FrameCheck> frames;
    ErrorFigures training, held_out;  // frames = 0: there were no such frames
    // True if the mean of the truth was taken over its training frames; otherwise it is the model's stored mean.
    bool mean_from_truth = false;
    std::size_t far_vertices = 0;  // vertices in the sample of far_by_fields and far_by_rays; 0: there is none
};

// The other files that the asset is compared with. Each is null if it was not given.
struct CheckReferences {
    const VisibilityReader* predictions = nullptr;  // predictions of the same model
    const VisibilityReader* second_bake = nullptr;  // the same frames or some of them, with another seed or other rays
    const AssetView* unpacked = nullptr;            // the model that the asset was made of, as F32 with all components
    FarQuality quality = FarQuality::kFull;         // only matters for composed assets
    WorstPairs* worst = nullptr;                    // gets E of every frame
};

// Returns the row of the bake for each vertex of the asset. A bake of chosen points has none for the vertices that
// follow them, which come last; the result then ends before them. Throws InvalidInput where neither count fits.
std::vector<std::uint32_t> bakedRows(const AssetView& asset, const VisibilityHeader& header);

// Throws InvalidInput when the mesh, skin, pose or order of the truth (or of the references) is not what the asset's
// model needs; when a second bake has the seed and rays of the truth; when an unpacked model has other vertices or
// another convention.
void checkFits(const AssetView& asset, const VisibilityHeader& truth, const CheckReferences& references);

// Returns the rank correlation of out_of_range and rms_v over the held-out frames; NaN where it is not defined.
double rangeCorrelation(const CheckResult& result);

// Checks an asset. Clips that the asset does not know count as held out. `predictions` must have every frame (clip
// and time) of the truth. Frames of a second bake must be in the poses of the truth. Everything must fit, or else it
// throws InvalidInput. The result is the same for any number of threads.
CheckResult checkAsset(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references,
                       int threads, const std::function<void(std::size_t)>& progress);

}  // namespace penumbra
