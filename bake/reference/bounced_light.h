#pragma once
// Traces the light that reaches a point by diffuse reflections of other surfaces, and through them.
#include "bake/reference/reference_scene.h"

namespace penumbra {

// Returns the integral of f L cos over the directions that hit the mesh, where L is the light that the mesh reflects
// after 1 to scene.bounces reflections; a passage through a sheet (ReferenceFrame::transmission) counts as one. It
// traces a quarter of `samples` paths. Backs of one-sided meshes, occluders and the ground reflect nothing. The same
// `seed` gives the same number.
Vec3d bouncedLight(const ReferenceScene& scene, const SurfacePoint& point, const EnvironmentLight& light,
                   const SampledBrdf& material, int samples, std::uint64_t seed);

}  // namespace penumbra
