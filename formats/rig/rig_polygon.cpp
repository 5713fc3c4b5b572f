// Cuts polygons into triangles.
//
// Problem: FBX, Collada and .x have polygons of any number of corners, some of them on a straight line between their
// neighbours, where other polygons end. All of the polygon must be covered, and every corner needs a triangle with an
// area, or its surface has no point there.
//
// Naive: a fan from the first corner, which covers too much of a polygon that is not convex; or assimp's own triangles,
// of which it drops those that are small in the file's units.
//
// Here: ears are cut off (Meisters 1975, "Polygons have ears"), the one with the shortest cut first. A corner on a line
// is no ear, so that it stays until a neighbour's ear takes it. Four corners are cut as assimp cuts them.
#include "formats/rig/rig_polygon.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

constexpr std::size_t kMaxCorners = 512;  // more are cut as a fan
constexpr float kStraight = 1e-3f;        // radians that rounding of floats bends a line by
constexpr double kOnLine = 1e-7;          // the sine of an angle that rounding of floats makes

// Cuts four corners from the one that points inwards or is on a line, or else from the first.
void cutQuad(std::span<const Vec3> points, std::span<const std::uint32_t> c, std::vector<Triangle>& out) {
    std::size_t start = 0;
    for (std::size_t i = 0; i < 4 && start == 0; ++i) {
        const Vec3 at = points[c[i]];
        const Vec3 before = normalized(points[c[(i + 3) % 4]] - at), across = normalized(points[c[(i + 2) % 4]] - at),
                   after = normalized(points[c[(i + 1) % 4]] - at);
        if (std::acos(std::clamp(dot(before, across), -1.0f, 1.0f)) +
                std::acos(std::clamp(dot(after, across), -1.0f, 1.0f)) >
            3.14159265f - kStraight)
            start = i;
    }
    out.push_back({c[start], c[(start + 1) % 4], c[(start + 2) % 4]});
    out.push_back({c[start], c[(start + 2) % 4], c[(start + 3) % 4]});
}

void cutFan(std::span<const std::uint32_t> c, std::vector<Triangle>& out) {
    for (std::size_t k = 2; k < c.size(); ++k) out.push_back({c[0], c[k - 1], c[k]});
}

// Newell's normal, twice the area long.
Vec3d normalOf(std::span<const Vec3> points, std::span<const std::uint32_t> c) {
    Vec3d sum;
    const Vec3d origin = toDouble(points[c[0]]);
    for (std::size_t k = 0; k < c.size(); ++k)
        sum += cross(toDouble(points[c[k]]) - origin, toDouble(points[c[(k + 1) % c.size()]]) - origin);
    return sum;
}

// The rest of a polygon while ears are cut off.
struct Rest {
    std::span<const Vec3> points;
    Vec3d normal;  // unit
    std::vector<std::uint32_t> corners;

    Vec3d at(std::size_t k) const { return toDouble(points[corners[k % corners.size()]]); }
    double turn(Vec3d a, Vec3d b, Vec3d c) const { return dot(cross(b - a, c - b), normal); }

    // Tells whether corner k is an ear: its neighbours see each other inside of the polygon.
    bool isEar(std::size_t k) const {
        const std::size_t n = corners.size();
        const Vec3d a = at(k + n - 1), b = at(k), c = at(k + 1);
        if (!(turn(a, b, c) > kOnLine * length(b - a) * length(c - b))) return false;
        for (std::size_t i = k + 2; i < k + n - 1; ++i) {
            const Vec3d p = at(i);
            if (p == a || p == b || p == c) continue;
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    }
};

}  // namespace

void cutPolygon(std::span<const Vec3> points, std::span<const std::uint32_t> corners, std::vector<Triangle>& out) {
    if (corners.size() < 3) return;
    if (corners.size() == 3) return out.push_back({corners[0], corners[1], corners[2]});
    if (corners.size() == 4) return cutQuad(points, corners, out);
    const Vec3d normal = normalized(normalOf(points, corners));
    if (corners.size() > kMaxCorners || !(dot(normal, normal) > 0)) return cutFan(corners, out);
    Rest rest{points, normal, {corners.begin(), corners.end()}};
    while (rest.corners.size() > 3) {
        const std::size_t n = rest.corners.size();
        std::size_t best = n;
        double shortest = 0;
        for (std::size_t k = 0; k < n; ++k) {
            const double cut = length(rest.at(k + 1) - rest.at(k + n - 1));
            if ((best < n && cut >= shortest) || !rest.isEar(k)) continue;
            best = k;
            shortest = cut;
        }
        if (best == n) break;  // it crosses itself, or a line is left
        out.push_back({rest.corners[(best + n - 1) % n], rest.corners[best], rest.corners[(best + 1) % n]});
        rest.corners.erase(rest.corners.begin() + std::ptrdiff_t(best));
    }
    cutFan(rest.corners, out);
}

}  // namespace penumbra
