#pragma once
// The part of project_map for angular maps and mirror balls. The integral over a pixel becomes one around its border
// (Stokes): with azimuth q and polar angle t(r), of y_lm dw = q_lm(t) {cos, sin}(mq) sin t dt dq it is that of
// I_lm(t) {cos, sin}(mq) dq, I_lm(t) = integral of q_lm sin from 0 to t. Borders that two pixels of one colour share
// cancel to the last bit, and the density is 0 outside of the disc: the rim needs no clipping.
// Frame: z' towards the centre of the disc, x' = u' and y' = v; u' = u for balls, -u for angular maps (right-handed).
#include <array>
#include <span>

#include "formats/image/environment_map.h"
#include "sh/sh_basis.h"

namespace penumbra {

struct PartialProjection {
    std::array<Vec3d, coefficientCount(kMaxOrder)> sh{};
    double energy = 0;
};

// J_l+1 = ((2l+1) s^2 P_l^m + (l-1)(l+m) J_l-1) / ((l-m+1)(l+2)), J_l the integral of P_l^m from z to 1: from
// d/dz (1-z^2) P_l^m. With the normalisation of y in both factors.
struct DiscBasis {
    int order = 0;
    std::array<double, kMaxOrder> start{};                                             // q_mm / sin^m
    std::array<std::array<double, kMaxOrder>, kMaxOrder> from_basis{}, from_before{};  // of I_l+1,m: [l][m]
    std::array<double, coefficientCount(kMaxOrder)> whole{};                           // I_lm(pi)
};
DiscBasis makeDiscBasis(int order);
// I_lm(polar) at shIndex(l, m >= 0).
void integrateBasis(const DiscBasis& basis, double polar, std::span<double> out);

int rowCount(const EnvironmentMap& map);  // of projectDiscRow: borders between rows, one more than rows, for discs
std::span<const Vec3> rowOf(const Image& image, int row);
// Borders along grid line `row` and, below it, between the pixels of row `row`.
void projectDiscRow(const EnvironmentMap& map, int row, const DiscBasis& basis, PartialProjection& sum);

}  // namespace penumbra
