#pragma once
// Functions that are mirrored at the horizon (convention D, sh/visibility_convention.h) and their products. Only
// coefficients with even l+m are stored, in the order of evenIndices(). What lies below the horizon never mixes in, and
// a product takes a fraction of the terms of one over the whole sphere (docs/formulas.md, section 7).
#include <span>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int mirroredCount(int order) { return order * (order + 1) / 2; }

// Mirrors what a function f has above the horizon: out_i = 2 integral over the upper hemisphere of f y_i.
// `coefficients` are those of f over the whole sphere, [order^2] in the local frame; out.size() ==
// mirroredCount(order). order <= kMaxOrder.
void mirrorAtHorizon(int order, std::span<const float> coefficients, std::span<float> out);

// Computes the product of two mirrored functions, exact for the bands that are given, up to `order_out`. `out` may not
// overlap a or b. Orders <= kMaxOrder.
void multiplyMirrored(int order_out, std::span<const float> a, int order_a, std::span<const float> b, int order_b,
                      std::span<float> out);

}  // namespace penumbra
