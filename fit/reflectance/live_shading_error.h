#pragma once
// The shading error of a lobe about the mirror direction (sh/brdf/mirror_lobe.h), which has no slices: numbers of D5
// become moments b = G d of order 6, and the radiance is (R l) . M (R b) with the rotation R to the mirror direction.
// The run time computes the same sums in single precision (runtime/shade/live_lobe.h).
#include <vector>

#include "fit/reflectance/shading_error.h"
#include "sh/brdf/brdf_lobe.h"

namespace penumbra {

// Returns the radiance of one point in double precision. `coefficients` are of the mirrored convention of this order,
// in the local frame, and so are `light`, [light_order^2] of one channel, and the view. The moments get `moment_order`
// bands.
double liveRadiance(const BrdfLobe& lobe, int light_order, std::span<const double> light, int order,
                    std::span<const double> coefficients, int moment_order, Vec3d view);

// Returns the relative RMSE over the reference scenes, for D5 and moments of order 6. `source` is the lobe to evaluate.
double liveShadingError(const RgbBrdf& source, const BrdfLobe& lobe, int threads);

}  // namespace penumbra
