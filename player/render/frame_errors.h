#pragma once
// Compares the model with baked truth, frame by frame and over frames, in the terms of docs/formulas.md, section 5.
// The figures are those of penumbra-pack check.
#include <optional>

#include "player/papers/transfer_error.h"
#include "sh/error_tail.h"

namespace penumbra {

// Each vertex' mean of the truth over training frames, [V, stride], or the model's own mean where the truth has none
// of them.
struct TruthMean {
    std::vector<double> coefficients;
    bool from_truth = false;
};
// Averages over all training frames that the truth has. `frame` loses its pose.
TruthMean truthMean(PosedFrame& frame);

// Sums over the vertices of one frame. They add up to those of a set of frames. y are the truth's numbers, y' the
// model's, and E is ambient visibility.
struct ErrorSums {
    std::size_t frames = 0, vertices = 0;
    double ambient = 0;      // sum |E(y') - E(y)|
    double ambient_max = 0;  // largest term of that sum; NaN where a term is
    double squares = 0;      // sum |y' - y|^2
    double variation = 0;    // sum |y - mean y|^2; NaN without a mean
    double transfer = 0;     // sum E_transfer (player/papers/transfer_error.h); NaN where it is not measured
    ErrorTail tail{};        // of |E(y') - E(y)|

    void add(const ErrorSums& other);
    double ambientMean() const { return ambient / double(vertices); }
    double transferMean() const { return transfer / double(vertices); }
    double rmsV() const;           // sqrt(squares / vertices / 4 pi); of transfer the rms of T instead
    double relativeError() const;  // sqrt(squares / variation); NaN or infinity where there is nothing to divide by
};

// Returns the errors of the frame as it is posed; it must have truth. `mean` and `transfer` may be null.
ErrorSums errorsOf(PosedFrame& frame, const TruthMean* mean, const TransferError* transfer = nullptr);

}  // namespace penumbra
