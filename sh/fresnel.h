#pragma once
// Returns the Fresnel reflectance of a smooth dielectric for unpolarised light from outside. `cosine` is h.wi in [0,
// 1], and `ior` >= 1.
#include <cmath>

namespace penumbra {

inline double dielectricFresnel(double cosine, double ior) {
    const double g = std::sqrt(ior * ior - 1 + cosine * cosine);  // ior times the cosine of the refracted ray
    if (g + cosine <= 0) return 1;                                // ior = 1 at grazing incidence
    const double s = (g - cosine) / (g + cosine), p = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
    return s * s / 2 * (1 + p * p);  // Cook and Torrance 1982, eq. 18
}

}  // namespace penumbra
