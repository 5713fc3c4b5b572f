#pragma once
// Evaluates the lobes of a material for a sun. Lambert, GGX and the parts of glTF's material are evaluated in single
// precision and without a local frame, because most materials consist of them. The other models go through evalLobes().
// The formulas are those of brdf_glsl.h.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "runtime/shade/shading.h"
#include "sh/brdf/brdf_lobe.h"

namespace penumbra {

// A point and who looks at it. The eye is mirrored to the side of the normal.
struct LobeSurface {
    Vec3 normal, tangent, to_eye;  // unit
    float eye_cosine;              // cosine between normal and to_eye, >= 0
};

inline LobeSurface lobeSurface(Vec3 position, Vec3 normal, Vec3 tangent, Vec3 eye) {
    const Vec3 to_eye = normalized(eye - position);
    const float cosine = dot(normal, to_eye);
    return {normal, tangent, cosine < 0 ? to_eye - normal * (2 * cosine) : to_eye, std::abs(cosine)};
}

// Schlick's Fresnel term between f0 and f90, of a half vector as long as wi + wo; `size2` is its squared length.
inline float schlickBetween(float f0, float f90, float size2) {
    const float c = std::max(1 - 0.5f * std::sqrt(size2), 0.0f);
    return f0 + (f90 - f0) * (c * c * c * c * c);
}

// The squared sine of the half vector comes from its part across the normal, which has all its digits where it is
// small.
inline float ggxLobe(float alpha, float f0, float f90, const LobeSurface& at, Vec3 to_sun, float sun_cosine) {
    const float a2 = alpha * alpha, i = std::max(sun_cosine, 1e-9f), o = std::max(at.eye_cosine, 1e-9f);
    const Vec3 h = to_sun + at.to_eye, across = cross(at.normal, h);
    const float size2 = dot(h, h), z = i + o, base = (a2 * z * z + dot(across, across)) / size2;
    // 1 + lambda(i) + lambda(o) = smith / (2 i o)
    const float smith = o * std::sqrt(i * i + a2 * (1 - i * i)) + i * std::sqrt(o * o + a2 * (1 - o * o));
    return a2 * schlickBetween(f0, f90, size2) / (2 * std::numbers::pi_v<float> * base * base * smith);
}

// Returns what evalLobes() does of one lobe, without its colour; nothing for models that need the local frame.
inline std::optional<float> framelessLobe(const BrdfLobe& lobe, const LobeSurface& at, Vec3 to_sun, float sun_cosine) {
    const auto& p = lobe.parameters;
    switch (lobe.model) {
        case BrdfModel::kLambert:
            return std::numbers::inv_pi_v<float>;
        case BrdfModel::kGgx:
            return ggxLobe(p[0], p[1], 1, at, to_sun, sun_cosine);
        case BrdfModel::kGgxF0:
            return ggxLobe(p[0] * p[0], 1, 0, at, to_sun, sun_cosine);
        case BrdfModel::kGgxF90:
            return ggxLobe(p[0] * p[0], 0, 1, at, to_sun, sun_cosine);
        case BrdfModel::kPrincipledDiffuse: {
            const Vec3 h = to_sun + at.to_eye;
            return (1 - schlickBetween(p[0], p[1], dot(h, h))) * std::numbers::inv_pi_v<float>;
        }
        default:
            return std::nullopt;
    }
}

// Returns evalLobes() for a sun in the direction `to_sun`, whose cosine with the normal is above 0.
inline Vec3 sunLobes(std::span<const BrdfLobe> lobes, const LobeSurface& at, Vec3 to_sun, float sun_cosine) {
    Vec3 sum;
    if (!(at.eye_cosine > 0)) return sum;
    for (const BrdfLobe& lobe : lobes) {
        if (const std::optional<float> f = framelessLobe(lobe, at, to_sun, sun_cosine)) {
            sum += lobe.color * *f;
        } else {
            const Mat3 local = toLocalFrame(at.normal, at.tangent);
            sum += evalLobes({&lobe, 1}, local * to_sun, local * at.to_eye);
        }
    }
    return sum;
}

}  // namespace penumbra
