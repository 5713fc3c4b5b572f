#pragma once
// The bones of a mesh that has no skeleton: near-rigid parts follow its vertices, and inputs are joints of their own.
// The fit, the prediction and the run time all call these functions, so all see the same bits.
#include <cstdint>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

// The sums that partMotions() makes for a part. The caller owns the memory.
struct PartSums {
    Vec3d rest, position;  // means
    Mat3d cross;           // sum of (position - mean)(rest - mean)^T
    double size = 0;       // sum of |rest - mean|^2
    double count = 0;
};

// Fits a rigid motion to each part by least squares (Procrustes). bones[p] is the rotation, never a reflection, and the
// translation that bring the rest positions of the vertices of part p nearest to `positions`. What they leave open is
// turned as little as possible, by a prior of 1e-5 of the part's size: a part of one vertex does not turn, and a line
// does not turn about itself. A part without vertices stays at rest. `rest`, `part_of_vertex` and `positions` are [Vs];
// parts < sums.size() == bones.size(). Sums are made in double and in the order of the vertices.
void partMotions(std::span<const Vec3> rest, std::span<const std::uint16_t> part_of_vertex,
                 std::span<const Vec3> positions, std::span<PartSums> sums, std::span<Affine> bones);

// These return the bone of an input joint. A point that rests at `center` gives its way from there. Any other number
// gives the translation by ((x - offset) scale, 0, 0).
Affine pointBone(Vec3 point, Vec3 center);
Affine numberBone(float x, float offset, float scale);

}  // namespace penumbra
