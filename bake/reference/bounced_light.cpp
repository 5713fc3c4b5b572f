// Traces paths of light through the mesh, whose surface reflects diffusely.
//
// A path leaves the shaded point in a direction that its material chooses. At each surface point that it meets, two
// shadow rays estimate the light of the environment there, and a direction with the density cos / pi leads on. With
// this density the albedo is the whole factor of a reflection. "Light that bounces" in docs/formulas.md has the terms.
#include "bake/reference/bounced_light.h"

#include <algorithm>
#include <optional>

#include "bake/common/random_numbers.h"

namespace penumbra {

namespace {

// A point that a path meets, and what the surface reflects there.
struct PathPoint {
    SurfacePoint surface;
    Vec3d albedo;
};

// Returns the next point of a path, or nothing where light cannot come from a surface.
std::optional<PathPoint> nextPoint(const ReferenceScene& scene, Vec3 origin, Vec3d direction) {
    const ReferenceFrame& input = scene.input;
    if (input.ground && direction.y < 0) return std::nullopt;
    const std::optional<SurfaceHit> hit = scene.blocking().closestHit(origin, toFloat(direction));
    if (!hit || hit->triangle >= input.mesh.frontTriangleCount()) return std::nullopt;
    const bool back = dot(toDouble(hit->normal), direction) > 0;
    if (back && !input.mesh.two_sided) return std::nullopt;
    const Corners corners = cornersOf(input, *hit, direction);
    PathPoint point{surfacePoint(scene, corners, -direction), {}};
    if (point.surface.closed) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k) point.albedo += toDouble(input.albedo[corners.vertex[k]]) * corners.weight[k];
    return point;
}

Vec3d inModelFrame(const SurfacePoint& point, Vec3d local) { return transposed(point.frame) * local; }

// Returns the light that arrives at `origin` from `direction` by reflections. `state` draws the path's random numbers.
Vec3d lightAlongPath(const ReferenceScene& scene, Vec3 origin, Vec3d direction, const EnvironmentLight& light,
                     std::uint64_t& state) {
    static const SampledBrdf white = sampledBrdf(rgbBrdf({}));  // 1 / pi
    const ShadowCaster caster{scene.blocking(), scene.input.ground};
    Vec3d sum, share{1, 1, 1};
    for (int k = 0; k < scene.bounces; ++k) {
        const std::optional<PathPoint> point = nextPoint(scene, origin, direction);
        if (!point) break;
        share = share * point->albedo;
        const std::uint64_t seed = nextRandom(state) >> 8;
        sum += share * directLight(caster, point->surface, light, white, 4, seed);
        const double u = nextUniform(state), v = nextUniform(state);
        direction = inModelFrame(point->surface, sampleCosine({u, v}));
        origin = point->surface.ray_origin;
    }
    return sum;
}

}  // namespace

Vec3d bouncedLight(const ReferenceScene& scene, const SurfacePoint& point, const EnvironmentLight& light,
                   const SampledBrdf& material, int samples, std::uint64_t seed) {
    const SamplingLobe& lobe = material.lobe;
    const int paths = std::max(1, samples / 4);
    const int of_lobe = int(paths * lobe.share), of_cosine = paths - of_lobe;
    const Vec3d wo = viewDirection(point);
    std::uint64_t state = seed * 0x9e3779b97f4a7c15u + 1;
    Vec3d sum;
    // Each direction counts by the density with which both sets together draw it, as in directLight().
    const auto add = [&](Vec3d wi) {
        if (wi.z <= 0) return;
        const Vec3d f = material.brdf.eval(wi, wo) * wi.z;
        if (f.x + f.y + f.z <= 0) return;
        const double density = of_cosine * cosineDensity(wi) + (of_lobe > 0 ? of_lobe * lobeDensity(lobe, wo, wi) : 0);
        sum += lightAlongPath(scene, point.ray_origin, inModelFrame(point, wi), light, state) * f / density;
    };
    for (int i = 0; i < of_cosine; ++i) add(sampleCosine(stratified(i, of_cosine, 2 * seed)));
    for (int i = 0; i < of_lobe; ++i) add(sampleLobe(lobe, wo, stratified(i, of_lobe, 2 * seed + 1)));
    return sum;
}

}  // namespace penumbra
