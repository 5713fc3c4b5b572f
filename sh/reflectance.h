#pragma once
// Reflectance slices (docs/formulas.md section 3). The cosine-weighted BRDF as seen from omega_o is f = C
// y_even(omega_o), where C has J^2 rows for the slice order J and E columns for the E z-even SH (l+m even) of the view
// order. Shading is L = l . (f x v) with the exact Gamma.
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

// Returns the SH indices i < order^2 with l+m even in ascending order; there are order (order+1)/2 of them.
std::vector<int> evenIndices(int order);

// Evaluates y_even(direction), the z-even basis functions only. out.size() == evenIndices(order).size().
void evalEvenBasis(int order, Vec3 direction, std::span<float> out);

}  // namespace penumbra
