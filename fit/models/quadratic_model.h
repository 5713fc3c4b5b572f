#pragma once
// The papers' quadratic model (paper 000 section 5.3): a ridge regression on the PCA inputs and all their products. The
// squares of inputs grow with the square of their unit, so callers scale the inputs to a spread of about 1 first.
#include <cstddef>
#include <span>

#include "fit/numerics/matrix.h"

namespace penumbra {

constexpr std::size_t quadraticCount(std::size_t inputs) { return inputs + inputs * (inputs + 1) / 2; }

// x_0 .. x_(I-1), then x_i x_j for i <= j, j fastest; out.size() == quadraticCount(x.size()). The run-time evaluator
// repeats this order.
void quadraticInputs(std::span<const double> x, std::span<double> out);

Matrix quadraticInputs(const Matrix& inputs);  // of every row

}  // namespace penumbra
