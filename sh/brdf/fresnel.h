#pragma once
// Fresnel terms. `cosine` is h.wi in [0, 1].
#include <algorithm>
#include <cmath>

namespace penumbra {

// Schlick 1994, eq. 15: from the reflectance f0 at normal incidence to f90 at grazing incidence, which is 1 there.
inline double schlickFresnel(double cosine, double f0, double f90 = 1) {
    const double c = std::max(1 - cosine, 0.0);  // rounding can make the cosine larger than 1
    return f0 + (f90 - f0) * (c * c * c * c * c);
}

// Returns the Fresnel reflectance of a smooth dielectric for unpolarised light from outside. `ior` >= 1.
inline double dielectricFresnel(double cosine, double ior) {
    const double g = std::sqrt(ior * ior - 1 + cosine * cosine);  // ior times the cosine of the refracted ray
    if (g + cosine <= 0) return 1;                                // ior = 1 at grazing incidence
    const double s = (g - cosine) / (g + cosine), p = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
    return s * s / 2 * (1 + p * p);  // Cook and Torrance 1982, eq. 18
}

}  // namespace penumbra
