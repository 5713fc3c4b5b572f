#pragma once
// x.vis.h5 -> model: clusters, tangent frames, PCA and a ridge per cluster (docs/formulas.md section 4).
#include <functional>

#include "fit/visibility/fit_options.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct ErrorFigures {
    double relative_error = 0, rms_v = 0, ambient_error = 0;  // docs/formulas.md section 5
};

struct FitReport {
    ErrorFigures train, held_out;  // of all training, all held-out frames; the latter zeros when there are none
    std::size_t train_frames = 0, held_out_frames = 0;
    double cross_validated_error = 0;  // relative error by blocked cross-validation over training frames
    double leave_one_out_error = 0;    // of the scores, relative to their spread: optimistic, to compare with the above
    double output_floor = 0;           // relative error over training frames that the output PCA alone leaves
    double largest_tangent_angle = 0;  // radians, over neighbours of one cluster in the rest pose
};

struct FitResult {
    Model model;
    FitReport report;
};

// `phase` is told the name of each phase, `progress` the share done in it; either may be empty.
struct FitObserver {
    std::function<void(const char*)> phase;
    std::function<void(double)> progress;
};

// `file` names the reader's file in messages: UsageError for options that do not go with it, InvalidInput or
// Unsupported for a file that cannot be fitted.
void checkFit(const VisibilityHeader& header, const std::string& file, const FitOptions& options);
// The same errors.
FitResult fitVisibility(const VisibilityReader& reader, const std::string& file, const FitOptions& options,
                        const FitObserver& observer);
// The request of the poses that such a fit reads.
PoseRequest poseRequest(const VisibilityHeader& header, const FitOptions& options);
// The same with what readPoses() gave, for several fits of one file.
FitResult fitVisibility(const VisibilityReader& reader, const PoseTable& poses, const std::string& file,
                        const FitOptions& options, const FitObserver& observer);

}  // namespace penumbra
