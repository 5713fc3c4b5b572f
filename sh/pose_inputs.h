#pragma once
// The inputs that a unit of an additive model sees of one bone. The fit computes them in double, the run time in float.
#include <cmath>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kBoneInputs = 13;

// An input may leave its range over training frames by this share of it before it is clamped.
constexpr float kRangeMargin = 0.1f;

// Writes 13 inputs: the direction and the logarithm of the distance at which the cluster sees the bone, and how the
// bone is turned, scaled to how large it looks from there. What a bone hides of the sky depends on these and not on the
// scale of the scene.
//   position: from the cluster's center to the bone's center, in the cluster bone's rest frame, in box diagonals;
//   turned: R_c^T R_j - I;
//   spread: square root of the second moments of the bone's rest vertices, in box diagonals. |turned spread|_F is then
//   the root mean square distance by which the rotation moves them.
// out[13] holds p / r, log r and (turned spread) / r row-major, where r^2 = |p|^2 + 0.01^2, so that no pose gives an
// infinite input.
template <class T>
void boneInputs(BasicVec3<T> position, const BasicMat3<T>& turned, const BasicMat3<T>& spread, T* out) {
    const T r = std::sqrt(dot(position, position) + T(1e-4)), over_r = 1 / r;
    out[0] = position.x * over_r;
    out[1] = position.y * over_r;
    out[2] = position.z * over_r;
    out[3] = std::log(r);
    const BasicMat3<T> moved = turned * spread;
    for (int i = 0; i < 9; ++i) out[4 + i] = moved.m[std::size_t(i)] * over_r;
}

}  // namespace penumbra
