#pragma once
// Real spherical harmonics, orthonormal over the sphere, with the Condon-Shortley sign: y(1,1) = -sqrt(3/4pi) x.
// "Order" counts bands: order 4 means bands 0..3 and 16 coefficients. Index i = l(l+1)+m.
#include <span>
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kMaxOrder = 8;                         // largest order of anything stored in a file
constexpr int kMaxProductOrder = 2 * kMaxOrder - 1;  // largest order of the third factor of an exact product
constexpr std::string_view kShConvention = "real-orthonormal-cs";  // written into every file that holds SH

constexpr int coefficientCount(int order) { return order * order; }
constexpr int shIndex(int band, int m) { return band * (band + 1) + m; }
int bandOfIndex(int index);

// Evaluates every basis function at the unit `direction`; out.size() == coefficientCount(order), 1 <= order <=
// kMaxOrder. It uses polynomial recurrences in x, y, z: no trigonometry, no division, exact at the poles.
void evalBasis(int order, Vec3 direction, std::span<float> out);
void evalBasis(int order, Vec3d direction, std::span<double> out);

// Evaluates the definition, slowly: associated Legendre functions by recurrence and cos and sin of the azimuth. 1 <=
// order <= kMaxProductOrder. Tests compare evalBasis() with it, and tables that are made once use it.
void evalBasisReference(int order, Vec3d direction, std::span<double> out);

}  // namespace penumbra
