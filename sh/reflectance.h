#pragma once
// Reflectance slices, docs/formulas.md section 3: the cosine-weighted BRDF as seen from omega_o is f = C
// y_even(omega_o), with J = slice order, E = number of z-even SH (l+m even) of order E_order. Shading: L = l . (f x v),
// Gamma exact.
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kSliceOrder = 5;      // J: 25 coefficients in the incident direction
constexpr int kSliceViewOrder = 5;  // 15 z-even functions of the view direction

// SH indices i < order^2 with l+m even, ascending; order (order+1)/2 of them.
std::vector<int> evenIndices(int order);

// y_even(direction): the z-even basis values only. out.size() == evenIndices(order).size().
void evalEvenBasis(int order, Vec3 direction, std::span<float> out);

// f_i = sum_e C[i, e] y_even_e(omega_o); slices row-major [J^2, E] of one colour channel. Local frame.
void evalSlice(std::span<const float> slices, int slice_order, int view_order, Vec3 omega_o, std::span<float> f);

}  // namespace penumbra
