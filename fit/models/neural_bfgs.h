#pragma once
// The papers' optimiser of paper 000 eq 13: BFGS or L-BFGS over all weights at once, through Ceres. It is the reference
// for the fast optimiser (variable_projection.h).
#include "fit/models/variable_projection.h"

namespace penumbra {

// 5000 iterations: paper 000, section 5.3.
constexpr SearchOptions kPapersSearch{
    .method = QuasiNewton::kBfgs, .iterations = 5000, .least_decrease = 1e-10, .window = 1};

// Minimises eq 13 from all weights of `start`. Weights outside a neuron's range stay zero. Throws std::runtime_error
// when the objective is not finite at the start.
NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const SearchOptions& options = kPapersSearch);

}  // namespace penumbra
