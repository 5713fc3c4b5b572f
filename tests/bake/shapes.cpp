#include "tests/bake/shapes.h"

namespace penumbra::shapes {

std::vector<SeenTriangle> seenFrom(Vec3d origin, const Shape& shape) {
    std::vector<SeenTriangle> seen;
    for (const Triangle& t : shape.triangles) {
        const Vec3d a = toDouble(shape.positions[t[0]]), s = origin - a;
        const Vec3d e1 = toDouble(shape.positions[t[1]]) - a, e2 = toDouble(shape.positions[t[2]]) - a;
        const Vec3d q = cross(s, e1);
        seen.push_back({e1, e2, s, q, dot(e2, q)});
    }
    return seen;
}

bool blocked(const std::vector<SeenTriangle>& seen, Vec3d direction) {
    for (const auto& [e1, e2, s, q, height] : seen) {
        const Vec3d p = cross(direction, e2);
        const double determinant = dot(e1, p);
        if (determinant == 0) continue;
        const double u = dot(s, p) / determinant;
        if (!(u >= 0)) continue;
        const double v = dot(direction, q) / determinant;
        if (v >= 0 && u + v <= 1 && height / determinant > 0) return true;
    }
    return false;
}

}  // namespace penumbra::shapes
