#pragma once
// A sphere that stands for what lies around a bone when a character casts shadow (paper 000, section 7).
#include <cmath>

#include "sh/vec3.h"

namespace penumbra {

struct BlockerSphere {
    Vec3 center;       // in the space of the rest positions
    float radius = 0;  // > 0, in that space
    constexpr bool operator==(const BlockerSphere&) const = default;
};

// Returns the sphere where a bone (skinning matrix) takes it. A bone that scales takes the radius with it: the cube of
// the radius changes as volumes do.
inline BlockerSphere movedBy(const Affine& bone, const BlockerSphere& sphere) {
    const Mat3 a = bone.linear();
    const float determinant =
        dot(Vec3{a.m[0], a.m[1], a.m[2]}, cross(Vec3{a.m[3], a.m[4], a.m[5]}, Vec3{a.m[6], a.m[7], a.m[8]}));
    return {bone.point(sphere.center), sphere.radius * std::cbrt(std::abs(determinant))};
}

}  // namespace penumbra
