#pragma once
// Rotations as quaternions in the order x y z w, as glTF has them.
#include <array>
#include <optional>

#include "sh/vec3.h"

namespace penumbra {

using Quaternion = std::array<double, 4>;

Quaternion multiply(const Quaternion& a, const Quaternion& b);
Quaternion conjugate(const Quaternion& q);
// Returns nothing where the length is 0 or not finite.
std::optional<Quaternion> normalized(const Quaternion& q);
// Goes along the shortest great arc from a to b, both unit; t in 0..1.
Quaternion slerp(const Quaternion& a, const Quaternion& b, double t);
// Returns the logarithm of a unit quaternion: axis times angle, in radians, of length <= pi.
Vec3d rotationVector(const Quaternion& q);
Quaternion rotationOf(Vec3d rotation_vector);  // the exponential, inverse of rotationVector()
Quaternion quaternionOf(const Mat3d& rotation);
Mat3d matrixOf(const Quaternion& q);  // `q` is a unit quaternion

}  // namespace penumbra
