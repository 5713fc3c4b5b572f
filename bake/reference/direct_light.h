#pragma once
// Computes the outgoing radiance of a shadowed point by Monte Carlo integration, for an environment light and any
// BRDF, without an approximation.
#include <cstdint>

#include "bake/reference/environment_light.h"
#include "bake/reference/sampling_lobe.h"
#include "bake/trace/occlusion.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

// A mesh casts shadows and, with `ground`, an infinite floor, which blocks every direction with y < 0.
struct ShadowCaster {
    const OcclusionScene& scene;
    bool ground = false;

    bool blocks(Vec3 origin, Vec3d direction) const {
        return (ground && direction.y < 0) || scene.occluded(origin, toFloat(direction), 0);
    }
};

// A point of a surface in the ray tracer's frame (SceneScale).
struct SurfacePoint {
    Vec3 ray_origin;           // already lifted off the surface
    Mat3d frame;               // rows: tangent, bitangent, normal; model frame to local frame
    Vec3d to_eye;              // unit, model frame
    bool closed = false;       // another surface lies on the point, so no light reaches it
    std::uint32_t member = 0;  // member of a scene (ReferenceFrame::member_of_vertex); 0 for a floor
};

// Returns a view direction in the local frame that BRDFs can take. It is at least 1e-3 above the horizon, since
// interpolated normals may face away from the eye where the surface does not.
Vec3d viewDirection(const SurfacePoint& point);

// A BRDF and how to sample it.
struct SampledBrdf {
    RgbBrdf brdf;
    SamplingLobe lobe;
};
SampledBrdf sampledBrdf(RgbBrdf brdf);  // fits the lobe by fitLobe()

// Returns the integral of f L V cos over the hemisphere, by `samples` shadow rays. Stratified sets for the light's
// luminance, the cosine and the BRDF's lobe are joined by the balance heuristic (Veach 1997). The same `seed` gives
// the same number.
Vec3d directLight(const ShadowCaster& caster, const SurfacePoint& point, const EnvironmentLight& light,
                  const SampledBrdf& material, int samples, std::uint64_t seed);

// Returns cosine-weighted visibility / pi, which is 1 where nothing blocks.
double ambientVisibility(const ShadowCaster& caster, const SurfacePoint& point, int samples, std::uint64_t seed);

// Makes a right-handed frame with z = unit normal. Its tangent is the model's x axis turned by the shortest rotation
// that takes y (or, below the equator, -y) to the normal, which is continuous on either side of the equator. This
// tangent is a stand-in: anisotropic BRDFs want the tangents of a fitted model.
Mat3d shadingFrame(Vec3d normal);
// Makes a frame whose tangent points as nearly as possible along `wanted_tangent`. Uses the stand-in where that is
// parallel to the normal.
Mat3d shadingFrame(Vec3d normal, Vec3d wanted_tangent);

}  // namespace penumbra
