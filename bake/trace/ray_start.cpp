// Finds where the rays of a point of a sheet start.
//
// Problem: the rays of a point must leave the surface that the point lies on without being blocked by it, but must
// not miss any other surface. Cloth makes this hard: it lies on skin, on other cloth and on itself, often nearer than
// any fixed offset, and a simulation lets it sink a little into the body below.
//
// Naive: start every ray at a fixed offset (the bias) along the normal. Where another surface is nearer than the
// offset, the rays start behind it and the point sees light that it should not see. Where the cloth has sunk in, all
// rays start inside the body and the point is black.
//
// Here: one search ray looks along the normal first, surface by surface, and the three rules of ray_start.h decide at
// each surface whether the rays start before it, beyond it, or not at all. The search costs a few rays for each
// point, against hundreds that are traced from it. Section 2 of docs/formulas.md defines the integral that those rays
// measure.
//
// Over a solid the fixed offset is enough: startOverSolid() in ray_start.h. startOfVertex() in bake/trace/moments.cpp
// chooses between the two for a bake. startOfShadowRays() in bake/reference/bake_reference.cpp decides for pictures
// whether a point needs the search.
#include "bake/trace/ray_start.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {
// A surface that the search ray meets.
struct Met {
    float distance;  // from the point
    bool front;      // true if its front faces the rays
    // The closed surface, without its sign: the sign has gone into `front`.
    std::int32_t solid;
    std::uint32_t triangle;
};

// Finds the first surface beyond `from` and up to `to`, two distances from the point along `direction`.
std::optional<Met> nextSurface(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at,
                               Vec3 direction, float from, float to) {
    // The ray starts a little behind the point, so that what touches it is met whichever side rounding puts it on.
    const Vec3 origin = at.position - direction * kTouching;
    const auto hit = scene.nextHit(origin, direction, {from + kTouching, to + kTouching}, at.own);
    if (!hit) return std::nullopt;
    const std::int32_t solid = blockers.solid[hit->triangle];
    const bool towards = dot(hit->normal, direction) < 0;
    return Met{hit->distance - kTouching, solid < 0 ? !towards : towards, std::abs(solid), hit->triangle};
}

// Returns the next distance at which the search goes on, a step that floats can tell from `distance`.
float beyond(float distance) { return std::nextafter(distance, INFINITY) + 1e-7f; }

// Measures how far it is backwards out of the solid. The answer is infinite when the solid's wall is not the first
// surface that lies there.
float wayOutBackwards(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at,
                      std::int32_t solid) {
    const auto met = nextSurface(scene, blockers, at, -at.direction, -kTouching, kSunkIn);
    return met && !met->front && met->solid == solid ? met->distance : INFINITY;
}

}  // namespace

RayStart startOverSheet(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& at) {
    constexpr int kMaxSurfaces = 64;
    // Rule 1 needs to see twice the bias, because a surface at that distance halves to the bias. Rule 2 needs to see
    // kSunkIn.
    const float reach = std::max(2 * at.bias, kSunkIn);
    // `base` is where the way out of the solids has come to. `from` is where the search goes on.
    float base = 0, from = -kTouching;
    for (int i = 0; i < kMaxSurfaces; ++i) {
        const auto met = nextSurface(scene, blockers, at, at.direction, from, base + reach);
        if (!met) break;
        // The back of a solid that is not the point's own: beyond this surface the search ray is outside of that
        // solid.
        const bool leaves = !met->front && met->solid != 0 && met->solid != at.solid;
        if (met->distance <= kTouching) {
            // Rule 3: a touching front closes the point. A touching back is passed.
            if (met->front) return {at.position, true, met->triangle};
        } else if (leaves && met->distance <= kSunkIn &&
                   met->distance <= wayOutBackwards(scene, blockers, at, met->solid)) {
            // Rule 2: the way out leads through this surface, and it is not longer than the way out backwards.
            base = met->distance;
        } else {
            // Rule 1: any other surface ends the search.
            return {at.position + at.direction * (base + std::min(at.bias, (met->distance - base) / 2))};
        }
        from = beyond(met->distance);
    }
    // Nothing is near.
    return {at.position + at.direction * (base + at.bias)};
}

}  // namespace penumbra
