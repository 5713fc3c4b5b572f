#pragma once
// The papers' optimiser of paper 000 eq 13: BFGS or L-BFGS over all weights at once, through Ceres. It is the reference
// for the fast optimiser (variable_projection.h).
#include <limits>

#include "fit/models/variable_projection.h"

namespace penumbra {

enum class QuasiNewton { kBfgs, kLbfgs };

struct BfgsOptions {
    QuasiNewton method = QuasiNewton::kBfgs;
    int iterations = 5000;  // paper 000, section 5.3
    // Stops when an iteration lowers the objective by less than this part of it. With 0, only `iterations` stops it.
    double least_decrease = 1e-10;
};

// Minimises eq 13 from all weights of `start`. Weights outside a neuron's range stay zero. Throws std::runtime_error
// when the objective is not finite at the start.
NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const BfgsOptions& options = {});

}  // namespace penumbra
