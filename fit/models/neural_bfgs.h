#pragma once
// The papers' optimiser of eq 13: (L-)BFGS over all weights at once, through Ceres. The reference for the fast one.
#include <limits>

#include "fit/models/variable_projection.h"

namespace penumbra {

enum class QuasiNewton { kBfgs, kLbfgs };

struct BfgsOptions {
    QuasiNewton method = QuasiNewton::kBfgs;
    int iterations = 5000;  // paper 000, section 5.3
    double least_decrease =
        1e-10;  // of the objective in one iteration, as a part of it; 0: only the iterations stop it
};

// Starts at all weights of `start`; weights outside a neuron's range stay zero. Throws std::runtime_error when the
// objective is not finite at the start.
NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const BfgsOptions& options = {});

}  // namespace penumbra
