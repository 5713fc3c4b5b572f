#include "bake/reference/direct_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace penumbra {

namespace {

Vec3d toWorld(const Mat3d& frame, Vec3d local) { return transposed(frame) * local; }

}  // namespace

Mat3d shadingFrame(Vec3d normal) {
    // The shortest rotation of (0, s, 0) to the normal, s = +-1, applied to the x axis (Duff et al. 2017, with y for
    // z).
    const double s = normal.y >= 0 ? 1 : -1, a = 1 / (1 + s * normal.y);
    const Vec3d tangent{1 - normal.x * normal.x * a, -s * normal.x, -normal.x * normal.z * a};
    return fromRows(tangent, cross(normal, tangent), normal);
}

Mat3d shadingFrame(Vec3d normal, Vec3d wanted_tangent) {
    const Vec3d tangent = wanted_tangent - normal * dot(normal, wanted_tangent);
    if (dot(tangent, tangent) < 1e-12) return shadingFrame(normal);
    const Vec3d x = normalized(tangent);
    return fromRows(x, cross(normal, x), normal);
}

SampledBrdf sampledBrdf(RgbBrdf brdf) {
    const SamplingLobe lobe = fitLobe(brdf);
    return {std::move(brdf), lobe};
}

Vec3d viewDirection(const SurfacePoint& point) {
    Vec3d wo = point.frame * point.to_eye;
    wo.z = std::max(wo.z, 1e-3);
    return normalized(wo);
}

Vec3d directLight(const ShadowCaster& caster, const SurfacePoint& point, const EnvironmentLight& light,
                  const SampledBrdf& material, int samples, std::uint64_t seed) {
    const SamplingLobe& lobe = material.lobe;
    // 1. Half of the samples follow the light. The others follow the BRDF: its lobe, and the cosine.
    const int of_light = samples / 2, of_lobe = int((samples - of_light) * lobe.share);
    const int of_cosine = samples - of_light - of_lobe;
    const Vec3d wo = viewDirection(point);
    Vec3d sum;
    // 2. Each direction counts by the density with which all three sets together draw it. `wi` is the direction in
    // the local frame.
    const auto add = [&](Vec3d direction, Vec3d wi) {
        if (wi.z <= 0) return;
        const Vec3d f = material.brdf.eval(wi, wo) * wi.z;
        if (f.x + f.y + f.z <= 0 || caster.blocks(point.ray_origin, direction)) return;
        const double density = of_light * light.density(direction) + of_cosine * cosineDensity(wi) +
                               (of_lobe > 0 ? of_lobe * lobeDensity(lobe, wo, wi) : 0);
        sum += light.radiance(direction) * f / density;
    };
    for (int i = 0; i < of_light; ++i) {
        const UnitSquare s = stratified(i, of_light, 3 * seed);
        const Vec3d direction = light.sample(s.u, s.v).direction;
        add(direction, point.frame * direction);
    }
    for (int i = 0; i < of_cosine; ++i) {
        const Vec3d wi = sampleCosine(stratified(i, of_cosine, 3 * seed + 1));
        add(toWorld(point.frame, wi), wi);
    }
    for (int i = 0; i < of_lobe; ++i) {
        const Vec3d wi = sampleLobe(lobe, wo, stratified(i, of_lobe, 3 * seed + 2));
        add(toWorld(point.frame, wi), wi);
    }
    // 3. No sample hits a directional light, so each of these gets a shadow ray of its own.
    for (const DirectionalLight& delta : light.directional()) {
        const Vec3d wi = point.frame * delta.direction;
        if (wi.z > 0 && !caster.blocks(point.ray_origin, delta.direction))
            sum += delta.irradiance * material.brdf.eval(wi, wo) * wi.z;
    }
    return sum;
}

double ambientVisibility(const ShadowCaster& caster, const SurfacePoint& point, int samples, std::uint64_t seed) {
    int visible = 0;
    for (int i = 0; i < samples; ++i) {
        const Vec3d direction = toWorld(point.frame, sampleCosine(stratified(i, samples, seed)));
        visible += !caster.blocks(point.ray_origin, direction);
    }
    return double(visible) / samples;
}

}  // namespace penumbra
