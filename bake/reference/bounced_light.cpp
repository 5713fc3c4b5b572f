// Traces paths of light through the mesh, whose surface reflects diffusely.
//
// A path leaves the shaded point in a direction that its material chooses. At each surface point that it meets, shadow
// rays estimate the light of the environment there, and a direction with the density cos / pi leads on. With this
// density the albedo is the whole factor of a reflection. "Light that bounces" in docs/formulas.md has the terms.
//
// A sheet that lets light through shines with albedo E + transmission E' over pi, from the light E on the side that the
// path meets and E' on the other side. A path that followed both sides would split at every point. Instead the light of
// the environment is estimated on both, and the path goes on from one of them, chosen at random by its share of both.
#include "bake/reference/bounced_light.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "bake/common/random_numbers.h"
#include "sh/quadrature.h"

namespace penumbra {

namespace {

// A side of the surface that a path meets, and how much of the light on this side comes back along the path.
struct Side {
    SurfacePoint point;
    Vec3d factor;
};
struct PathHit {
    Side met;
    std::optional<Side> other;  // the far side of a sheet that lets light through
};

Vec3d colorAt(std::span<const Vec3> colors, const Corners& corners) {
    Vec3d sum;
    for (std::size_t k = 0; k < 3; ++k) sum += toDouble(colors[corners.vertex[k]]) * corners.weight[k];
    return sum;
}

// Where the floor stands in the ray tracer's frame.
double floorHeight(const ReferenceScene& scene) {
    return (scene.input.floor->height - scene.scale.center.y) / scene.scale.diagonal;
}

bool isBelowFloor(const ReferenceScene& scene, Vec3 origin, Vec3d direction, const SurfaceHit& hit) {
    return double(origin.y) + double(hit.distance) * direction.y < floorHeight(scene);
}

// Returns the point of the floor that a path meets, or nothing where the floor reflects nothing.
std::optional<PathHit> floorHit(const ReferenceScene& scene, Vec3 origin, Vec3d direction) {
    if (!scene.input.floor) return std::nullopt;
    const double distance = std::max((floorHeight(scene) - double(origin.y)) / direction.y, 0.0);
    Vec3d point = toDouble(origin) + direction * distance;
    point.y = floorHeight(scene) + scene.bias;
    return PathHit{{{toFloat(point), shadingFrame(Vec3d{0, 1, 0}), -direction}, toDouble(scene.input.floor->albedo)},
                   {}};
}

// Returns what a path meets next, or nothing where light cannot come from a surface.
std::optional<PathHit> nextHit(const ReferenceScene& scene, Vec3 origin, Vec3d direction) {
    const ReferenceFrame& input = scene.input;
    const std::optional<SurfaceHit> hit = scene.blocking().closestHit(origin, toFloat(direction));
    if (input.ground && direction.y < 0 && (!input.floor || !hit || isBelowFloor(scene, origin, direction, *hit)))
        return floorHit(scene, origin, direction);
    if (!hit || hit->triangle >= input.mesh.frontTriangleCount()) return std::nullopt;
    const bool back = dot(toDouble(hit->normal), direction) > 0;
    const Corners corners = cornersOf(input, *hit, direction);
    if (back && !input.mesh.two_sided && corners.vertex == input.mesh.triangles[hit->triangle]) return std::nullopt;
    PathHit found{{surfacePoint(scene, corners, -direction), colorAt(input.albedo, corners)}, {}};
    if (!input.transmission.empty())
        found.other = {surfacePoint(scene, otherSide(input, corners), direction), colorAt(input.transmission, corners)};
    if (found.met.point.closed && (!found.other || found.other->point.closed)) return std::nullopt;
    return found;
}

// Chooses the side from which a path goes on that has brought the share `share` of the light so far. The factor of this
// side is then divided by its chance.
Side chooseSide(const PathHit& hit, Vec3d share, std::uint64_t& state) {
    if (!hit.other) return hit.met;
    const auto weight = [&](Vec3d factor) { return dot(share, factor); };
    const double through = weight(hit.other->factor), both = weight(hit.met.factor) + through;
    const double chance = both > 0 ? through / both : 0;
    if (nextUniform(state) < chance) return {hit.other->point, hit.other->factor / chance};
    return {hit.met.point, hit.met.factor / (1 - chance)};
}

Vec3d inModelFrame(const SurfacePoint& point, Vec3d local) { return transposed(point.frame) * local; }

// Returns the light that arrives at a point from `direction` by reflections and through sheets. `state` draws the
// path's random numbers.
Vec3d lightAlongPath(const ReferenceScene& scene, const SurfacePoint& from, Vec3d direction,
                     const EnvironmentLight& light, std::uint64_t& state) {
    Vec3 origin = from.ray_origin;
    std::uint32_t member = from.member;
    static const SampledBrdf white = sampledBrdf(rgbBrdf({}));  // 1 / pi
    const ShadowCaster caster{scene.blocking(), scene.input.ground};
    const auto litFrom = [&](const Side& side) {
        if (side.point.closed) return Vec3d();
        return side.factor * directLight(caster, side.point, light, white, 4, nextRandom(state) >> 8);
    };
    Vec3d sum, share{1, 1, 1};
    for (int k = 0; k < scene.bounces; ++k) {
        const std::optional<PathHit> hit = nextHit(scene, origin, direction);
        if (!hit || (scene.input.others_alone && hit->met.point.member == member)) break;
        member = hit->met.point.member;
        sum += share * litFrom(hit->met);
        if (hit->other) sum += share * litFrom(*hit->other);
        const Side next = chooseSide(*hit, share, state);
        if (next.point.closed) break;
        share = share * next.factor;
        const double u = nextUniform(state), v = nextUniform(state);
        direction = inModelFrame(next.point, sampleCosine({u, v}));
        origin = next.point.ray_origin;
    }
    return sum;
}

}  // namespace

Vec3d whiteAlbedo(const RgbBrdf& brdf) {
    const std::vector<WeightedDirection> directions = gaussHemisphere(8, 16);
    Vec3d sum;
    for (const WeightedDirection& in : directions)
        for (const WeightedDirection& out : directions)
            sum += brdf.eval(in.direction, out.direction) *
                   (in.weight * in.direction.z * out.weight * out.direction.z / std::numbers::pi);
    return sum;
}

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
        sum += lightAlongPath(scene, point, inModelFrame(point, wi), light, state) * f / density;
    };
    for (int i = 0; i < of_cosine; ++i) add(sampleCosine(stratified(i, of_cosine, 2 * seed)));
    for (int i = 0; i < of_lobe; ++i) add(sampleLobe(lobe, wo, stratified(i, of_lobe, 2 * seed + 1)));
    return sum;
}

}  // namespace penumbra
