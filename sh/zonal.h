#pragma once
// Zonal harmonics: z_l is the true SH coefficient y(l,0) of a lobe aligned with +z.
#include <span>

#include "sh/sh_basis.h"

namespace penumbra {

// Turns a lobe from +z to the unit `axis`: g_lm = sqrt(4pi/(2l+1)) z_l y_lm(axis) (Nowrouzezahrai 2008 eq. 1 corrected,
// Nowrouzezahrai 2011 eq. 3). z.size() == order, out.size() == coefficientCount(order).
void rotateZonal(std::span<const double> z, Vec3d axis, std::span<double> out);

// Writes the exact z_l of max(0, cos theta): sqrt(pi)/2, sqrt(pi/3), sqrt(5pi)/8, 0, ... z.size() == order.
void clampedCosineZonal(std::span<double> z);

// Writes the z_l of the function that is 1 where s.z < height, else 0. -1 <= height <= 1, z.size() == order.
void belowPlaneZonal(double height, std::span<double> z);

// Writes the z_l of the visibility that a blocked cap of half-angle `angle` around +z leaves (Nowrouzezahrai 2011 eq.
// 22-23 corrected).
void capVisibilityZonal(double angle, std::span<double> z);

}  // namespace penumbra
