#pragma once
// Outgoing radiance of a shadowed point by Monte Carlo: environment light, any BRDF, no approximation.
#include <cstdint>

#include "bake/brdf_lobe.h"
#include "bake/environment_light.h"
#include "bake/occlusion.h"
#include "sh/brdf.h"

namespace penumbra {

// What casts shadows: a mesh and, with `ground`, an infinite floor that blocks every direction with y < 0.
struct ShadowCaster {
    const OcclusionScene& scene;
    bool ground = false;

    bool blocks(Vec3 origin, Vec3d direction) const {
        return (ground && direction.y < 0) || scene.occluded(origin, toFloat(direction), 0);
    }
};

// A point of a surface in the ray tracer's frame (SceneScale).
struct SurfacePoint {
    Vec3 ray_origin;      // already lifted off the surface
    Mat3d frame;          // rows: tangent, bitangent, normal; model frame to local frame
    Vec3d to_eye;         // unit, model frame
    bool closed = false;  // another surface lies on it: no light comes
};

// Local-frame view direction that BRDFs can take: at least 1e-3 above the horizon, since interpolated normals may face
// away from the eye where the surface does not.
Vec3d viewDirection(const SurfacePoint& point);

// A BRDF and how to sample it.
struct SampledBrdf {
    RgbBrdf brdf;
    BrdfLobe lobe;
};
SampledBrdf sampledBrdf(RgbBrdf brdf);  // with fitLobe()

// Integral of f L V cos over the hemisphere with `samples` shadow rays: stratified sets for the light's luminance, the
// cosine and the BRDF's lobe, joined by the balance heuristic (Veach 1997). The same `seed` gives the same number.
Vec3d directLight(const ShadowCaster& caster, const SurfacePoint& point, const EnvironmentLight& light,
                  const SampledBrdf& material, int samples, std::uint64_t seed);

// Cosine-weighted visibility / pi: 1 = unshadowed.
double ambientVisibility(const ShadowCaster& caster, const SurfacePoint& point, int samples, std::uint64_t seed);

// Right-handed frame with z = unit normal. The tangent is the model's x axis turned by the shortest rotation that takes
// y (or, below the equator, -y) to the normal: continuous on either side of the equator. A stand-in: anisotropic BRDFs
// want the tangents of a fitted model.
Mat3d shadingFrame(Vec3d normal);
// The same with the tangent in the direction of `wanted_tangent`; the stand-in where that is along the normal.
Mat3d shadingFrame(Vec3d normal, Vec3d wanted_tangent);

}  // namespace penumbra
