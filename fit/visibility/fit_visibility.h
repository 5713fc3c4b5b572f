#pragma once
// Turns a visibility file into a model: clusters, tangent frames, and a PCA and a model of its scores for each cluster
// (docs/formulas.md section 4).
#include <functional>
#include <optional>

#include "fit/visibility/error_figures.h"
#include "fit/visibility/far_error.h"
#include "fit/visibility/fit_options.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Relative errors of whole predictions, of some clusters, in cross-validation over blocks of training frames.
struct NearReport {
    double local_alone = 0, hidden_learned = 0, hidden_opened = 0;  // the last two with near parts
    double with_near = 0;                                           // the chosen one of the two
};

// Errors of the parts of a composed model, each over training and held-out frames.
struct ComposedReport {
    ErrorFigures local_train, local_held_out;      // the local model against local moments
    ErrorFigures without_train, without_held_out;  // local x far, without the residual
    ErrorFigures split_train, split_held_out;      // true local moments x far: the limit for any local model
    double residual_cross_validated = 0;           // relative error of the residual model; 1 is as good as none
    bool residual_kept = false;
    bool near_kept = false;
    std::optional<NearReport> near;  // where cross-validation chose between near parts and none
    bool mean_kept = false;          // its mean alone counts too, even where its components do not pay
    // The error that the fields cost. It is unset where no vertices are compared, and for a deforming mesh, which has
    // no parts to trace.
    std::optional<FarError> far = {};
};

struct FitReport {
    // Over all training and all held-out frames; the latter are zeros when there are none.
    ErrorFigures train, held_out;
    std::size_t train_frames = 0, held_out_frames = 0;
    double cross_validated_error = 0;  // relative error in blocked cross-validation over training frames
    // Relative error of leaving one frame out; optimistic, to compare with the line above.
    double leave_one_out_error = 0;
    double output_floor = 0;           // relative error over training frames that the output PCA alone leaves
    double largest_tangent_angle = 0;  // radians, over neighbours inside one cluster in the rest pose
    // Set for composed models, where cross_validated_error to output_floor are those of the local model.
    std::optional<ComposedReport> composed = {};
};

struct FitResult {
    Model model;
    FitReport report;
};

// `phase` is told the name of each phase, and `progress` the share of it that is done. Either may be empty.
struct FitObserver {
    std::function<void(const char*)> phase;
    std::function<void(double)> progress;
};

// Checks that a file can be fitted. `file` names it in messages. Throws UsageError for options that do not go with the
// file, and InvalidInput when it cannot be fitted.
void checkFit(const VisibilityHeader& header, const std::string& file, const FitOptions& options);
// Fits a model. Throws what checkFit() throws.
FitResult fitVisibility(const VisibilityReader& reader, const std::string& file, const FitOptions& options,
                        const FitObserver& observer);
// Returns the request for the poses that such a fit reads.
PoseRequest poseRequest(const VisibilityHeader& header, const FitOptions& options);
// Fits a model to poses that readPoses() returned for this request, so that several fits of one file can share them.
FitResult fitVisibility(const VisibilityReader& reader, const PoseTable& poses, const std::string& file,
                        const FitOptions& options, const FitObserver& observer);

}  // namespace penumbra
