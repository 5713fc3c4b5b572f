#pragma once
// The transfer of a Phong lobe in closed form: Nowrouzezahrai 2008 (1D BRDFs), appendix A, for any order
// (docs/formulas.md section 3).
#include <vector>

namespace penumbra {

constexpr int kPhongOrder = 4;  // order in the paper

// Returns M^alpha_ij = integral over z >= 0 of z^alpha y_i y_j, row-major [order^2, order^2], for any real alpha >= 0.
//
// Take the frame whose z is the mirror direction r of the view. There a lobe (alpha + 1)/(2 pi) max(0, r.s)^alpha of
// light l and visibility v has the radiance l^T t with t = (alpha + 1)/(2 pi) M^alpha v. The lobe ends at the plane
// across r and not at the surface, so v must be 0 below the surface (convention B). With alpha = 1 about the normal
// this is the clamped cosine over pi.
std::vector<double> phongMatrix(double alpha, int order = kPhongOrder);

}  // namespace penumbra
