#pragma once
// Cuts triangles at boxes (Sutherland and Hodgman, Reentrant Polygon Clipping, 1974).
#include <algorithm>
#include <array>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

using CutTriangle = std::array<Vec3d, 7>;  // every plane adds a corner at most

// Cuts a polygon at a plane: what has sign * corner[axis] <= limit is left. Returns its number of corners.
inline std::size_t cutAt(int axis, double sign, double limit, std::span<const Vec3d> polygon, CutTriangle& out) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3d a = polygon[i], b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double from = limit - sign * a[axis], to = limit - sign * b[axis];
        if (from >= 0) out[count++] = a;
        if ((from >= 0) != (to >= 0)) out[count++] = a + (b - a) * (from / (from - to));
    }
    return count;
}

// Gives what lies between two corners of a box, x and y alone. Returns its number of corners, 0 where nothing does.
inline std::size_t cutTriangle(const std::array<Vec3d, 3>& triangle, Vec3d low, Vec3d high, CutTriangle& out) {
    CutTriangle other;
    std::ranges::copy(triangle, out.begin());
    std::size_t count = 3;
    for (int axis = 0; axis < 2; ++axis) {
        count = cutAt(axis, -1, -low[axis], {out.data(), count}, other);
        count = cutAt(axis, 1, high[axis], {other.data(), count}, out);
    }
    return count;
}

}  // namespace penumbra
