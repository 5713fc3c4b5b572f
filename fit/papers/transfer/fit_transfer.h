#pragma once
// Fits the linear models of transfer to baked diffuse transfer: one linear map from the joint angles for each
// coefficient (section 14 of docs/formulas.md).
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fit/visibility/fit_visibility.h"
#include "formats/stage/transfer_error.h"
#include "formats/stage/transfer_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// How alpha is chosen: by leaving out each frame, as in the paper, or by leaving out blocks of frames.
enum class CrossValidation { kLeaveOneOut, kBlocks };
constexpr std::array<CrossValidation, 2> kCrossValidations{CrossValidation::kLeaveOneOut, CrossValidation::kBlocks};
constexpr const char* nameOf(CrossValidation kind) { return kind == CrossValidation::kLeaveOneOut ? "loo" : "blocks"; }

struct TransferFitOptions {
    TransferModelKind model = TransferModelKind::kPca;
    int order = 6;  // SH bands, 1..kMaxOrder
    // k and m of a PCA model: principal components of the angles and of the vertices, >= 1.
    std::size_t pose_components = 8, vertex_components = 22;
    CrossValidation cross_validation = CrossValidation::kLeaveOneOut;
    std::optional<double> prior;       // alpha; 0 fits without regularisation, none cross-validates
    std::vector<std::string> holdout;  // clips that no step sees; only their errors are measured
    // Fits the indirect transfer in this colour channel, of a bake with bounces. For comparisons.
    std::optional<std::size_t> indirect_channel{};
    int threads = 0;  // never changes the result
};

struct TransferClip {
    std::string clip;
    bool held_out = false;
    std::size_t frames = 0;
    TransferErrors errors;
};

struct TransferFitReport {
    std::size_t train_frames = 0, held_out_frames = 0;
    std::size_t constant_angles = 0;    // numbers of the pose that never change over the training frames
    double largest_singular_value = 0;  // singular value of the inputs, in units of alpha
    // Relative errors of the maps' outputs with that alpha, leaving out each frame and each block of frames. The
    // second is 0 when there is one block only.
    double leave_one_out_error = 0, blocked_error = 0;
    double pose_variance = 1, vertex_variance = 1;  // shares of the variance that the components keep
    TransferErrors train, held_out;
    std::vector<TransferClip> clips;
};

struct TransferFit {
    TransferModel model;
    TransferFitReport report;
};

// Throws UsageError for options that do not go with the file, and InvalidInput when it cannot be fitted.
void checkTransferFit(const VisibilityHeader& header, const std::string& file, const TransferFitOptions& options);
// `observer` is told the share of the errors that is measured.
TransferFit fitTransfer(const VisibilityReader& reader, const std::string& file, const TransferFitOptions& options,
                        const FitObserver& observer);

}  // namespace penumbra
