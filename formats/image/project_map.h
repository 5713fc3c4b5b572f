#pragma once
// Projects pictures of the sphere to SH. Pixels are patches of constant radiance. Their solid angles and the
// integrals of the basis over them are exact, so that a uniform picture of any layout has band 0 only
// (docs/formulas.md, section 6).
#include <vector>

#include "formats/image/environment_map.h"

namespace penumbra {

struct MapProjection {
    std::vector<double> sh;  // [order^2, 3]
    double energy = 0;       // integral of |L|^2 over the sphere, channels summed
};

// 1 <= order <= kMaxOrder. The numbers are the same for any number of threads.
MapProjection projectMap(const EnvironmentMap& map, int order, int threads);

}  // namespace penumbra
