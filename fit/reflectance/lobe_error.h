#pragma once
// Measures how well lobes stand for the material that they were fitted to.
#include <span>

#include "sh/brdf/brdf_lobe.h"

namespace penumbra {

// Returns the relative RMSE of the true radiance of the lobes against that of `source`, over all lights, occluders and
// views of the reference scenes (fit/reflectance/shading_scenes.h). No lobe may be a mirror.
double lobeError(const RgbBrdf& source, std::span<const BrdfLobe> lobes, int threads);

}  // namespace penumbra
