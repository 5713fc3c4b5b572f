#pragma once
// Learns the light that reaches a character from itself (docs/formulas.md, section 15): the indirect transfer of a
// bake with bounces, as a function of the pose, by the clusters and local frames of a model of its visibility.
#include "fit/visibility/fit_visibility.h"

namespace penumbra {

struct IndirectFitOptions {
    double output_variance = 0.9;  // share of the variance of a cluster's numbers that PCA keeps, in (0, 1]
    int threads = 0;
};

// Errors of the indirect transfer over some frames, each as a share of the direct transfer: rms over vertices,
// channels and coefficients of the error over rms of the direct transfer.
struct IndirectShares {
    double without = 0;  // error without any indirect light, so the share of the indirect light itself
    double mean = 0;     // error of each vertex' mean over training frames
    double model = 0;
    double ambient_error = 0;  // mean |E_ind of the model - true E_ind| / pi in luminance, under uniform light
};

struct IndirectReport {
    std::size_t train_frames = 0, held_out_frames = 0;
    IndirectShares train, held_out;              // the latter are zeros without held-out frames
    double train_error = 0, held_out_error = 0;  // relative errors of the numbers, as those of visibility
    double cross_validated_error = 0;
};

struct IndirectFit {
    IndirectModel model;
    IndirectReport report;
};

// Checks that the bake is one of diffuse transfer with bounces, of the model's character, and that all of its frames
// are the model's. `file` names it in messages. Throws InvalidInput, and UsageError where no frame is left to train on.
void checkIndirectFit(const Model& model, const VisibilityHeader& header, const std::string& file);
// Fits the frames of the bake that the model does not hold out. Throws what checkIndirectFit() throws.
IndirectFit fitIndirect(const Model& model, const VisibilityReader& reader, const std::string& file,
                        const IndirectFitOptions& options, const FitObserver& observer);

}  // namespace penumbra
