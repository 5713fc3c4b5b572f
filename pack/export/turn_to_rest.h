#pragma once
// Turns directions of the posed character back to the space of its rest positions, as an engine turns normals forth.
#include <span>

#include "formats/common/mesh.h"

namespace penumbra {

// The motion of a point: its bones, or, without influences, its normal at rest and its normal in the pose.
struct PointMotion {
    std::span<const std::uint16_t> joints;  // [K]
    std::span<const float> weights;         // [K]
    std::span<const Affine> bones;          // [J]
    Vec3 rest_normal, normal;
};

// Returns M^T v with the blended linear part M of the bones. Bones that turn and scale alike in all directions are
// inverted by that but for the length. Without bones it is the smallest rotation that takes `normal` to `rest_normal`.
Vec3 turnedToRest(const PointMotion& motion, Vec3 v);
// Returns the unit vector along turnedToRest(), or the normal at rest where v is 0.
Vec3 directionAtRest(const PointMotion& motion, Vec3 v);

}  // namespace penumbra
