#pragma once
// The tangent of a vertex' local frame. Fit, run time and brute-force pictures must all have exactly this one.
#include <cmath>

#include "sh/vec3.h"

namespace penumbra {

// Returns `wanted` made orthogonal to the unit `normal`, with length 1. Where nothing is left of it, it takes the
// coordinate axis that is least along the normal instead.
inline Vec3 tangentOf(Vec3 normal, Vec3 wanted) {
    const Vec3 tangent = wanted - normal * dot(normal, wanted);
    if (dot(tangent, tangent) > 1e-12f) return normalized(tangent);
    const Vec3 a{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
    const Vec3 axis = a.x <= a.y && a.x <= a.z ? Vec3{1, 0, 0} : a.y <= a.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    return normalized(axis - normal * dot(normal, axis));
}

}  // namespace penumbra
