#pragma once
// The papers' quadratic model (Nowrouzezahrai 2009 section 5.3): a ridge regression on the PCA inputs and all their
// products. A product grows with the square of the inputs' unit, so callers first scale the inputs to a spread of
// about 1.
#include <cstddef>
#include <span>

#include "fit/numerics/matrix.h"
#include "formats/common/model_kind.h"

namespace penumbra {

// Writes x_0 .. x_(I-1), then x_i x_j for i <= j, with j running fastest. out.size() == quadraticUnits(x.size()). The
// run-time evaluator uses the same order.
void quadraticInputs(std::span<const double> x, std::span<double> out);

// Does this for every row: [n, I] becomes [n, quadraticUnits(I)].
Matrix quadraticInputs(const Matrix& inputs);

}  // namespace penumbra
