#pragma once
// Reflectance slices (docs/formulas.md section 3). The cosine-weighted BRDF as seen from omega_o is f = C
// y_even(omega_o), where C has J^2 rows for the slice order J and E columns for the E z-even SH (l+m even) of the view
// order. Shading is L = l . (f x v) with the exact Gamma.
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kSliceOrder = 5;      // J: 25 coefficients in the incident direction
constexpr int kSliceViewOrder = 5;  // 15 z-even functions of the view direction

// Returns the SH indices i < order^2 with l+m even in ascending order; there are order (order+1)/2 of them.
std::vector<int> evenIndices(int order);

// Evaluates y_even(direction), the z-even basis functions only. out.size() == evenIndices(order).size().
void evalEvenBasis(int order, Vec3 direction, std::span<float> out);

// Evaluates f_i = sum_e C[i, e] y_even_e(omega_o) in the local frame. `slices` is [J^2, E], row-major, of one colour
// channel.
void evalSlice(std::span<const float> slices, int slice_order, int view_order, Vec3 omega_o, std::span<float> f);

}  // namespace penumbra
