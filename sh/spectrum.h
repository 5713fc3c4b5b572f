#pragma once
// Spectral reflectance to linear Rec.709 under the illuminant D65, whose colour is Rec.709's white.
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Rec.709 weight of each wavelength (nanometres, ascending, at least two): rgb = sum_k weights[k] R_k. R is linear
// between samples and constant beyond the ends; R = 1 gives (1, 1, 1) exactly. CIE 1931 colour matching functions as
// fitted by Wyman, Sloan and Shirley 2013. Saturated spectra lie outside Rec.709: a channel may come out negative.
std::vector<Vec3d> rec709Weights(std::span<const double> wavelengths);

}  // namespace penumbra
