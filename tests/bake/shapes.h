#pragma once
// Meshes with known answers, and a ray tracer without an acceleration structure.
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "formats/common/mesh.h"
#include "sh/quadrature.h"
#include "tests/sh/sh_project.h"

namespace penumbra::shapes {

struct Shape {
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
};

inline void append(Shape& to, const Shape& more) {
    const auto first = std::uint32_t(to.positions.size());
    to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
    for (Triangle t : more.triangles) to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

// Makes a latitude-longitude sphere; its vertices lie on the sphere.
inline Shape sphere(Vec3d center, double radius, int rings) {
    Shape s;
    const int columns = 2 * rings;
    s.positions.push_back(toFloat(center + Vec3d{0, radius, 0}));
    for (int i = 1; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const double t = std::numbers::pi * i / rings, p = 2 * std::numbers::pi * j / columns;
            s.positions.push_back(
                toFloat(center + Vec3d{std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p)} * radius));
        }
    s.positions.push_back(toFloat(center - Vec3d{0, radius, 0}));
    const auto last = std::uint32_t(s.positions.size() - 1);
    const auto at = [&](int i, int j) { return std::uint32_t(1 + (i - 1) * columns + j % columns); };
    for (int j = 0; j < columns; ++j) {
        s.triangles.push_back({0, at(1, j + 1), at(1, j)});
        s.triangles.push_back({last, at(rings - 1, j), at(rings - 1, j + 1)});
        for (int i = 1; i + 1 < rings; ++i) {
            s.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            s.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    }
    return s;
}

// Makes the part of the unit sphere with z <= top, whose fronts face inwards. Its rim is a ring of vertices.
inline Shape cavity(double top, int rings) {
    Shape s;
    const int columns = 2 * rings;
    const double rim = std::acos(top);
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const double t = rim + (std::numbers::pi - rim) * i / rings, p = 2 * std::numbers::pi * j / columns;
            s.positions.push_back(toFloat(Vec3d{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)}));
        }
    s.positions.push_back({0, 0, -1});
    const auto at = [&](int i, int j) { return std::uint32_t(i == rings ? i * columns : i * columns + j % columns); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            s.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (i + 1 < rings) s.triangles.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    return s;
}

// Makes a square of half-size `half` through `center`, perpendicular to `normal`.
inline Shape square(Vec3d center, Vec3d normal, double half) {
    const Vec3d side = std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d u = normalized(cross(normal, side)) * half, v = normalized(cross(normal, u)) * half;
    return {{toFloat(center - u - v), toFloat(center + u - v), toFloat(center + u + v), toFloat(center - u + v)},
            {{0, 1, 2}, {0, 2, 3}}};
}

// Makes two spheres that nearly touch, over a floor. They cast every kind of shadow.
inline Shape clutter(int rings) {
    Shape s = sphere({0, 1, 0}, 0.5, rings);
    append(s, sphere({0.8, 1.3, 0.3}, 0.45, rings));
    append(s, square({0, 0.3, 0}, {0, 1, 0}, 3));
    return s;
}

// A triangle as rays from one point meet it (Moeller and Trumbore 1997), in double: what all directions share.
struct SeenTriangle {
    Vec3d e1, e2, s, q;  // the edges from a; from a to the point; s x e1
    double height;       // e2 . q
};

std::vector<SeenTriangle> seenFrom(Vec3d origin, const Shape& shape);

// Tests for any hit beyond the origin.
bool blocked(const std::vector<SeenTriangle>& seen, Vec3d direction);

// Computes the hemisphere moments of one point over the plain Fibonacci set of 2 x 1024 directions, without the
// bake's code.
inline std::vector<double> bruteForceMoments(int order, Vec3d point, Vec3d normal, double lift, const Shape& shape) {
    static const std::vector<Vec3d> directions = fibonacciSphere(2048);
    const std::vector<SeenTriangle> seen = seenFrom(point + normal * lift, shape);
    std::vector<std::uint8_t> visible;
    for (const Vec3d& d : directions) visible.push_back(dot(d, normal) > 0 && !blocked(seen, d));
    std::vector<double> b(std::size_t(coefficientCount(order)));
    projectVisibility(order, directions, visible, b);
    return b;
}

}  // namespace penumbra::shapes
