#pragma once
// Computes the visibility above an infinite floor. It hides every direction that points down, from any height above it,
// so it needs no field: in the local frame of a receiver it only depends on how its normal stands to y, which is up.
#include <span>

#include "sh/far/far_kernel.h"

namespace penumbra {

// Writes the visibility past the floor, mirrored at each receiver's horizon, as 21 numbers a receiver in its local
// frame (FarPath::far). Exact but for linear interpolation in the tilt of the normal, to 1e-4. Normals and tangents are
// unit and orthogonal. Allocates nothing, but the first call makes a table.
void floorVisibility(std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> out);

// Multiplies far visibilities [receivers, 21] by that of the floor.
void multiplyByFloor(const FarPath& path, std::span<const Vec3> normals, std::span<const Vec3> tangents,
                     std::span<float> far);

}  // namespace penumbra
