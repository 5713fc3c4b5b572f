#pragma once
// Traces the light that reaches a point by diffuse reflections of other surfaces, and through them.
#include "bake/reference/reference_scene.h"

namespace penumbra {

// Returns the integral of f L cos over the directions that hit the mesh, where L is the light that the mesh reflects
// after 1 to scene.bounces reflections; a passage through a sheet (ReferenceFrame::transmission) counts as one. It
// traces a quarter of `samples` paths. Backs of one-sided meshes and occluders reflect nothing, and neither does a
// floor without ReferenceFrame::floor. The same `seed` gives the same number.
Vec3d bouncedLight(const ReferenceScene& scene, const SurfacePoint& point, const EnvironmentLight& light,
                   const SampledBrdf& material, int samples, std::uint64_t seed);

// Returns what a material reflects of white light from everywhere: 1/pi of the integral of f cos cos over both
// directions.
Vec3d whiteAlbedo(const RgbBrdf& brdf);

}  // namespace penumbra
