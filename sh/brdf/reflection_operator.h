#pragma once
// Reflection product operators (Nowrouzezahrai 2009 section 4, docs/formulas.md section 3): f(wi, wo) cos_i ~= sum_b
// U^b(wi) W^b(wo). u^b and w^b are their SH coefficients, w^b over the z-even functions y_even. Eq 10 is M^b_ij = sum_k
// u^b_k Gamma_ijk, and eq 11 is L = sum_b (w^b . y_even(omega_o)) l^T M^b v, all in the vertex' local frame.
#include <span>
#include <vector>

#include "sh/visibility_convention.h"

namespace penumbra {

constexpr int kMaxOperators = 16;  // largest k of a material

// Returns M for one u, row-major [light_order^2, convention.size()]. Column j belongs to number j of a vertex, so l^T M
// numbers needs no zeros of convention D. `u` has order^2 coefficients, order <= kMaxProductOrder. The product is exact
// for order >= light_order + convention.order - 1, and truncated below that.
std::vector<double> reflectionOperator(int light_order, const Convention& convention, std::span<const double> u);
std::vector<float> reflectionOperator(int light_order, const Convention& convention, std::span<const float> u);

}  // namespace penumbra
