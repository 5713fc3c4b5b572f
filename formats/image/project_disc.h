#pragma once
// Projects angular maps and mirror balls for project_map. The integral over a pixel becomes one around its border by
// Stokes' theorem (section 6 of docs/formulas.md): with azimuth q and polar angle t(r), the integral of y_lm dw =
// q_lm(t) {cos, sin}(mq) sin t dt dq is that of I_lm(t) {cos, sin}(mq) dq, I_lm(t) = integral of q_lm sin from 0 to
// t. Borders that two pixels of one colour share cancel to the last bit. The density is 0 outside of the disc, so
// that the rim needs no clipping. In the frame here z' points towards the center of the disc, x' = u' and y' = v. u'
// = u for balls and -u for angular maps (right-handed).
#include <array>
#include <span>

#include "formats/image/environment_map.h"
#include "sh/sh_basis.h"

namespace penumbra {

struct PartialProjection {
    std::array<Vec3d, coefficientCount(kMaxOrder)> sh{};
    double energy = 0;
};

// Holds J_l+1 = ((2l+1) s^2 P_l^m + (l-1)(l+m) J_l-1) / ((l-m+1)(l+2)), where J_l is the integral of P_l^m from z to
// 1. It follows from d/dz (1-z^2) P_l^m. Both factors contain the normalisation of y.
struct DiscBasis {
    int order = 0;
    std::array<double, kMaxOrder> start{};                                             // q_mm / sin^m
    std::array<std::array<double, kMaxOrder>, kMaxOrder> from_basis{}, from_before{};  // factors of I_l+1,m: [l][m]
    std::array<double, coefficientCount(kMaxOrder)> whole{};                           // I_lm(pi)
};
DiscBasis makeDiscBasis(int order);
// Writes I_lm(polar) at shIndex(l, m >= 0).
void integrateBasis(const DiscBasis& basis, double polar, std::span<double> out);

int rowCount(const EnvironmentMap& map);  // rows for projectDiscRow(): discs have one border more than rows
std::span<const Vec3> rowOf(const Image& image, int row);
// Adds the borders along grid line `row` and, below it, those between the pixels of row `row`.
void projectDiscRow(const EnvironmentMap& map, int row, const DiscBasis& basis, PartialProjection& sum);

}  // namespace penumbra
