#include "bake/direct_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

constexpr double kPi = std::numbers::pi;

// --- Points ---------------------------------------------------------------------------------------------------------

struct UnitSquare {
    double u, v;
};

static double hashToUnit(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return double((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

static double radicalInverse(std::uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
    return double(i) * 0x1p-32;
}

// Point i of n of the Hammersley set, shifted around the square by an offset of its own for each seed (Cranley and
// Patterson 1976).
static UnitSquare stratified(int i, int n, std::uint64_t seed) {
    double u = (i + 0.5) / n + hashToUnit(seed * 2 + 1),
           v = radicalInverse(std::uint32_t(i)) + hashToUnit(seed * 2 + 2);
    u -= std::floor(u);
    v -= std::floor(v);
    return {u, v};
}

// --- Lobes: local frame, densities per steradian
// ----------------------------------------------------------------------

static Vec3d onCircle(double z, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

static Vec3d sampleCosine(UnitSquare s) { return onCircle(std::sqrt(1 - s.u), 2 * kPi * s.v); }
static double cosineDensity(Vec3d wi) { return std::max(0.0, wi.z) / kPi; }

// Where a BRDF is large: (r.wi)^exponent around the mirror direction, or half vectors of a GGX distribution.
struct Lobe {
    enum class Kind { kNone, kPower, kHalfVector } kind = Kind::kNone;
    double parameter = 0;  // exponent, or roughness alpha
};

static Lobe lobeOf(const BrdfSpec& brdf) {
    const auto value = [&](const char* key) { return brdf.parameters.at(key); };
    if (brdf.name == "phong") return {Lobe::Kind::kPower, value("exponent")};
    if (brdf.name == "ggx") return {Lobe::Kind::kHalfVector, value("alpha")};
    if (brdf.name == "ward" || brdf.name == "ward-gmd")
        return {Lobe::Kind::kHalfVector, std::sqrt(value("ax") * value("ay"))};
    if (brdf.name == "ashikhmin-shirley")  // cos^n h is close to a GGX of alpha^2 = 2 / (n + 2)
        return {Lobe::Kind::kHalfVector, std::sqrt(2 / (std::sqrt(value("nu") * value("nv")) + 2))};
    return {};
}

static Vec3d toWorld(const Mat3d& frame, Vec3d local) { return transposed(frame) * local; }

static Vec3d sampleLobe(const Lobe& lobe, Vec3d wo, UnitSquare s) {
    if (lobe.kind == Lobe::Kind::kPower) {
        const Vec3d mirror{-wo.x, -wo.y, wo.z};
        return toWorld(shadingFrame(mirror), onCircle(std::pow(1 - s.u, 1 / (lobe.parameter + 1)), 2 * kPi * s.v));
    }
    const double a2 = lobe.parameter * lobe.parameter;
    const Vec3d h = onCircle(std::sqrt((1 - s.u) / (1 + (a2 - 1) * s.u)), 2 * kPi * s.v);
    return 2 * dot(wo, h) * h - wo;
}

static double lobeDensity(const Lobe& lobe, Vec3d wo, Vec3d wi) {
    if (lobe.kind == Lobe::Kind::kPower) {
        const double cosine = dot(Vec3d{-wo.x, -wo.y, wo.z}, wi);
        return cosine > 0 ? (lobe.parameter + 1) / (2 * kPi) * std::pow(cosine, lobe.parameter) : 0;
    }
    const Vec3d h = normalized(wi + wo);
    const double a2 = lobe.parameter * lobe.parameter, d = h.z * h.z * (a2 - 1) + 1, projected = std::abs(dot(wo, h));
    if (h.z <= 0 || projected <= 0) return 0;
    return a2 * h.z / (kPi * d * d) / (4 * projected);
}

// --- Integrals ------------------------------------------------------------------------------------------------------

Mat3d shadingFrame(Vec3d normal) {
    // Shortest rotation of (0, s, 0) to the normal, s = +-1, applied to the x axis (Duff et al. 2017, with y for z).
    const double s = normal.y >= 0 ? 1 : -1, a = 1 / (1 + s * normal.y);
    const Vec3d tangent{1 - normal.x * normal.x * a, -s * normal.x, -normal.x * normal.z * a};
    return fromRows(tangent, cross(normal, tangent), normal);
}

Vec3d viewDirection(const SurfacePoint& point) {
    Vec3d wo = point.frame * point.to_eye;
    wo.z = std::max(wo.z, 1e-3);
    return normalized(wo);
}

Vec3d directLight(const ShadowCaster& caster, const SurfacePoint& point, const EnvironmentLight& light,
                  const BrdfSpec& brdf, int samples, std::uint64_t seed) {
    const Lobe lobe = lobeOf(brdf);
    const int of_light = samples / 2, of_lobe = lobe.kind == Lobe::Kind::kNone ? 0 : samples / 4;
    const int of_cosine = samples - of_light - of_lobe;
    const Vec3d wo = viewDirection(point);
    Vec3d sum;
    // One direction of any of the sets; `wi` is the same in the local frame.
    const auto add = [&](Vec3d direction, Vec3d wi) {
        if (wi.z <= 0) return;
        const double f = evalBrdf(brdf, wi, wo) * wi.z;
        if (f <= 0 || caster.blocks(point.ray_origin, direction)) return;
        const double density = of_light * light.density(direction) + of_cosine * cosineDensity(wi) +
                               (of_lobe > 0 ? of_lobe * lobeDensity(lobe, wo, wi) : 0);
        sum += light.radiance(direction) * (f / density);
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
    return sum * brdf.color;
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
