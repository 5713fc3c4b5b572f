#pragma once
// A sphere that stands for what lies around a bone when a character casts shadow (Nowrouzezahrai 2009, section 7).
#include <cmath>

#include "sh/vec3.h"

namespace penumbra {

template <class T>
struct BasicCasterSphere {
    BasicVec3<T> center;
    T radius{};  // > 0
    constexpr bool operator==(const BasicCasterSphere&) const = default;
};
using CasterSphere = BasicCasterSphere<float>;
using CasterSphereD = BasicCasterSphere<double>;

// Returns the sphere where a bone (skinning matrix) takes it from the rest positions. A bone that scales takes the
// radius with it: the cube of the radius changes as volumes do.
inline CasterSphere movedBy(const Affine& bone, const CasterSphere& sphere) {
    const Mat3 a = bone.linear();
    const float determinant =
        dot(Vec3{a.m[0], a.m[1], a.m[2]}, cross(Vec3{a.m[3], a.m[4], a.m[5]}, Vec3{a.m[6], a.m[7], a.m[8]}));
    return {bone.point(sphere.center), sphere.radius * std::cbrt(std::abs(determinant))};
}

}  // namespace penumbra
