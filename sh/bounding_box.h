#pragma once
// The smallest box along the axes that holds some points.
#include <algorithm>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

struct BoundingBox {
    Vec3 low, high;
    // Half of the diagonal, in single precision; boxDiagonal() (formats/common/mesh.h) is the one in double precision.
    double radius() const { return 0.5 * double(length(high - low)); }
};

// The box around two boxes.
inline BoundingBox merged(const BoundingBox& a, const BoundingBox& b) {
    BoundingBox box;
    for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(a.low[axis], b.low[axis]);
        box.high[axis] = std::max(a.high[axis], b.high[axis]);
    }
    return box;
}

// Without points both corners are the origin.
inline BoundingBox boundsOf(std::span<const Vec3> points) {
    if (points.empty()) return {};
    BoundingBox box{points.front(), points.front()};
    for (const Vec3& p : points) box = merged(box, {p, p});
    return box;
}

}  // namespace penumbra
