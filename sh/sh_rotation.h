#pragma once
// Rotates SH coefficients: f'(s) = f(Q^T s) has coefficients R f, and y(Q s) = R y(s). R is block diagonal by band;
// band 1 is P Q P^T with P = [[0,-1,0],[0,0,1],[-1,0,0]]. Higher bands follow by recurrence (Ivanic and Ruedenberg),
// for any rotation.
#include <array>
#include <span>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int rotationEntryCount(int order) { return order * (4 * order * order - 1) / 3; }  // the sum of (2l+1)^2

template <class T>
struct BasicShRotation {
    int order = 0;
    std::array<T, rotationEntryCount(kMaxOrder)> blocks{};  // band after band, each block (2l+1)^2 row-major
};
using ShRotation = BasicShRotation<float>;
using ShRotationD = BasicShRotation<double>;

// `rotation` must be a proper rotation (orthonormal, det +1) to working precision.
ShRotation makeShRotation(int order, const Mat3& rotation);
ShRotationD makeShRotation(int order, const Mat3d& rotation);

// Computes out = R in. `in` and `out` have coefficientCount(r.order) elements and do not overlap.
void apply(const ShRotation& r, std::span<const float> in, std::span<float> out);
void apply(const ShRotationD& r, std::span<const double> in, std::span<double> out);
// Computes out = R^T in = R^-1 in.
void applyTransposed(const ShRotation& r, std::span<const float> in, std::span<float> out);
void applyTransposed(const ShRotationD& r, std::span<const double> in, std::span<double> out);

}  // namespace penumbra
