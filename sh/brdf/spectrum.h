#pragma once
// Turns spectral reflectance into linear Rec.709 under the illuminant D65, whose colour is Rec.709's white.
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Returns the Rec.709 weight of each wavelength, so that rgb = sum_k weights[k] R_k. Wavelengths are in nanometres,
// ascending, at least two. R is linear between samples and constant beyond the ends, and R = 1 gives (1, 1, 1) exactly.
// The CIE 1931 colour matching functions are those fitted by Wyman, Sloan and Shirley 2013. Saturated spectra lie
// outside Rec.709, so a channel may come out negative.
std::vector<Vec3d> rec709Weights(std::span<const double> wavelengths);

}  // namespace penumbra
