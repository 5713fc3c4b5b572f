#pragma once
// Nowrouzezahrai 2009 eq 13, and the papers' optimiser of it: BFGS or L-BFGS over all weights at once, through Ceres.
// It is the reference for the fast optimiser (fit/models/variable_projection.h).
#include "fit/models/variable_projection.h"

namespace penumbra {

// Returns the value of Nowrouzezahrai 2009 eq 13: sum over frames |prediction - y|^2 + alpha sum_n (|c^n|^2 + |d^n|^2).
// The biases are free.
double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha);

// Also sets `gradient` to the derivative by every weight.
double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha, TanhNet& gradient);

// 5000 iterations: Nowrouzezahrai 2009, section 5.3.
constexpr SearchOptions kPapersSearch{
    .method = QuasiNewton::kBfgs, .iterations = 5000, .least_decrease = 1e-10, .window = 1};

// Minimises eq 13 from all weights of `start`. Throws std::runtime_error
// when the objective is not finite at the start.
NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const SearchOptions& options = kPapersSearch);

}  // namespace penumbra
