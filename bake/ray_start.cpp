#include "bake/ray_start.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {
// A surface on the way.
struct Met {
    float distance;  // from the point
    bool front;      // it faces the rays
    std::int32_t solid;
};

// The first surface beyond `from`, a distance from the point.
std::optional<Met> nextSurface(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at,
                               Vec3 direction, float from, float to) {
    // The ray starts a little behind the point, so that what touches it is met whichever side rounding puts it on.
    const Vec3 origin = at.position - direction * kTouching;
    const auto hit = scene.nextHit(origin, direction, {from + kTouching, to + kTouching}, at.own);
    if (!hit) return std::nullopt;
    const std::int32_t solid = blockers.solid[hit->triangle];
    const bool towards = dot(hit->normal, direction) < 0;
    return Met{hit->distance - kTouching, solid < 0 ? !towards : towards, std::abs(solid)};
}

float beyond(float distance) { return std::nextafter(distance, INFINITY) + 1e-7f; }

// How far it is out of the solid backwards; infinite when its wall is not the first thing there.
float wayOutBackwards(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at,
                      std::int32_t solid) {
    const auto met = nextSurface(scene, blockers, at, -at.direction, -kTouching, kSunkIn);
    return met && !met->front && met->solid == solid ? met->distance : INFINITY;
}

}  // namespace

RayStart startOfRays(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at) {
    constexpr int kMostSurfaces = 64;
    const float reach = std::max(2 * at.bias, kSunkIn);
    float base = 0, from = -kTouching;
    for (int i = 0; i < kMostSurfaces; ++i) {
        const auto met = nextSurface(scene, blockers, at, at.direction, from, base + reach);
        if (!met) break;
        const bool leaves = !met->front && met->solid != 0 && met->solid != at.solid;
        if (met->distance <= kTouching) {
            if (met->front) return {at.position, true};
        } else if (leaves && met->distance <= kSunkIn &&
                   met->distance <= wayOutBackwards(scene, blockers, at, met->solid)) {
            base = met->distance;
        } else {
            return {at.position + at.direction * (base + std::min(at.bias, (met->distance - base) / 2)), false};
        }
        from = beyond(met->distance);
    }
    return {at.position + at.direction * (base + at.bias), false};
}

}  // namespace penumbra
