#include "bake/fields/part_surface.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sh/bounding_box.h"

namespace penumbra {

PartMesh partMesh(const Mesh& mesh, std::span<const std::uint32_t> twins,
                  std::span<const std::uint16_t> part_of_triangle, std::size_t part) {
    constexpr std::uint32_t kUnused = UINT32_MAX;
    const std::vector<Vec3>& positions = mesh.rest_positions;
    const std::vector<Triangle>& triangles = mesh.triangles;
    PartMesh out;
    std::vector<std::uint32_t> taken;  // triangles of the mesh
    std::vector<std::uint32_t> index_of_vertex(positions.size(), kUnused);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (part_of_triangle[t] != part) continue;
        taken.push_back(std::uint32_t(t));
        Triangle triangle{};
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t& index = index_of_vertex[triangles[t][c]];
            if (index == kUnused) {
                index = std::uint32_t(out.positions.size());
                out.positions.push_back(positions[triangles[t][c]]);
            }
            triangle[c] = index;
        }
        out.triangles.push_back(triangle);
    }
    out.opacity = opacityOf(mesh.opacity, taken);
    for (std::uint32_t t = 0; t < taken.size() && !twins.empty(); ++t) {
        const auto twin = std::lower_bound(taken.begin(), taken.end(), twins[taken[t]]);
        const bool inside = twin != taken.end() && *twin == twins[taken[t]];
        out.twins.push_back(inside ? std::uint32_t(twin - taken.begin()) : t);
    }
    return out;
}

// Moves the center towards the farthest point by ever smaller steps (Badoiu and Clarkson 2003, "Smaller core-sets for
// balls"), and keeps the best center on the way.
BoundingSphere boundingSphere(std::span<const Vec3> points) {
    constexpr int kSteps = 200;
    const BoundingBox box = boundsOf(points);
    Vec3d center = (toDouble(box.low) + toDouble(box.high)) * 0.5;
    BoundingSphere best{center, std::numeric_limits<double>::infinity()};
    for (int step = 0; step < kSteps; ++step) {
        Vec3d farthest;
        double square = -1;
        for (const Vec3& point : points) {
            const Vec3d offset = toDouble(point) - center;
            if (const double d = dot(offset, offset); d > square) {
                square = d;
                farthest = offset;
            }
        }
        if (std::sqrt(square) < best.radius) best = {center, std::sqrt(square)};
        center += farthest / double(step + 2);
    }
    return best;
}

namespace {

FieldBox boxOf(Vec3 low, Vec3 high, double cells) {
    FieldBox box{low, high, {}};
    const Vec3d extent = toDouble(box.high) - toDouble(box.low);
    const double side = std::cbrt(extent.x * extent.y * extent.z) / std::max(cells - 1, 1.0);
    for (int axis = 0; axis < 3; ++axis)
        box.size[std::size_t(axis)] = std::max(std::int32_t(std::ceil(extent[axis] / side - 0.3)) + 1, 4);
    return box;
}

constexpr float kFineBorder = 0.12f, kCoarseBorder = 0.9f;  // in radii
// A part has points in proportion to its fine box' volume to this power. Equal numbers (0) spend most of them on parts
// that cover little, equal cells (1) leave too few for a hand. Chosen on training frames of mh_male and the knight,
// whose errors of true local x far go from .264 and .322 to .245 and .272 at equal size.
constexpr double kPointsOfVolume = 0.75;
// The fine box of a part that stands has so many times the points. Parts are seen from afar, but the ground lies
// against soles. More would cost others too much at equal size (tests/bench/results/NOTES.md).
constexpr double kPointsOfStanding = 4;

// Lays planes of points onto the faces of a part's box, where it has an extent worth a cell. A sole is flat. What the
// ground below it looks up then lies between the plane of the sole and the next one outside, and no point inside of the
// part, which holds what its top or a side of it sees, has a share in that.
void layPlanesOnFaces(const BoundingBox& bounds, float radius, FieldBox& box) {
    constexpr float kAbove = 0.004f;  // in radii; points of the faces are outside
    constexpr float kThin = 0.5f;     // in cells
    constexpr float kShort = 0.2f;    // what the border may lack, in cells
    for (int axis = 0; axis < 3; ++axis) {
        std::int32_t& points = box.size[std::size_t(axis)];
        const float low = bounds.low[axis] - kAbove * radius, high = bounds.high[axis] + kAbove * radius;
        const float cell = (box.high[axis] - box.low[axis]) / float(points - 1);
        if (high - low < kThin * cell) continue;
        const float across = std::max(std::round((high - low) / cell), 1.0f), side = (high - low) / across;
        const float beyond = std::max(std::ceil(kFineBorder * radius / side - kShort), 1.0f);
        box.low[axis] = low - beyond * side;
        box.high[axis] = high + beyond * side;
        points = std::int32_t(across + 2 * beyond) + 1;
    }
}

PartField placeField(const PartMesh& mesh, double cells) {
    const BoundingSphere sphere = boundingSphere(mesh.positions);
    const BoundingBox bounds = boundsOf(mesh.positions);
    PartField part;
    part.center = toFloat(sphere.center);
    // A little more than the sphere, so that every triangle lies in the cone that a point is traced in.
    part.radius = float(sphere.radius * 1.001);
    // The coarse box also holds the smallest of the spheres of points, which take over from there.
    Vec3 fine_border, low = bounds.low, high = bounds.high;
    for (int axis = 0; axis < 3; ++axis) {
        const float sphere_radius = part.radius / kFieldSphereScales.back();
        fine_border[axis] = kFineBorder * part.radius;
        low[axis] = std::min(low[axis] - kCoarseBorder * part.radius, part.center[axis] - sphere_radius);
        high[axis] = std::max(high[axis] + kCoarseBorder * part.radius, part.center[axis] + sphere_radius);
    }
    const double fine_cells = mesh.stands ? cells * std::cbrt(kPointsOfStanding) : cells;
    part.boxes = {boxOf(bounds.low - fine_border, bounds.high + fine_border, fine_cells), boxOf(low, high, cells)};
    if (mesh.stands) layPlanesOnFaces(bounds, part.radius, part.boxes[0]);
    return part;
}

double volumeOf(const FieldBox& box) {
    const Vec3d extent = toDouble(box.high) - toDouble(box.low);
    return extent.x * extent.y * extent.z;
}

}  // namespace

std::vector<PartField> placeFields(std::span<const PartMesh> meshes, double cells, std::size_t most_bytes) {
    // 1. How many points each part has for each of the average.
    std::vector<double> share;
    double sum = 0;
    for (const PartMesh& mesh : meshes) {
        share.push_back(std::pow(volumeOf(placeField(mesh, cells).boxes[0]), kPointsOfVolume));
        sum += share.back();
    }
    // 2. As many as fit.
    constexpr double kMinCells = 2, kStep = 0.99;
    for (;; cells *= kStep) {
        std::vector<PartField> parts;
        std::size_t bytes = 0;
        for (std::size_t p = 0; p < meshes.size(); ++p) {
            const double of_mean = sum > 0 ? share[p] / sum * double(meshes.size()) : 1;
            parts.push_back(placeField(meshes[p], cells * std::cbrt(of_mean)));
            bytes += parts.back().pointCount() * kFieldCoefficients + parts.back().boxes[0].pointCount();
        }
        if (bytes <= most_bytes || cells < kMinCells) return parts;
    }
}

// --- Nearest point --------------------------------------------------------------------------------------------------

namespace {

// Ericson, "Real-Time Collision Detection" (2005), section 5.1.5: finds which corner, edge or inside of the triangle
// is nearest.
Vec3d nearestOnTriangle(Vec3d p, const std::array<Vec3d, 3>& corners) {
    const auto [a, b, c] = corners;
    const Vec3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    return a + (ab * vb + ac * vc) / (va + vb + vc);
}

}  // namespace

NearestSurface::NearestSurface(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    assert(!triangles.empty());
    for (const Triangle& triangle : triangles) {
        const std::array<Vec3d, 3> corners{toDouble(positions[triangle[0]]), toDouble(positions[triangle[1]]),
                                           toDouble(positions[triangle[2]])};
        const Vec3 center = toFloat((corners[0] + corners[1] + corners[2]) / 3.0);
        double radius = 0;
        for (const Vec3d& corner : corners) radius = std::max(radius, length(corner - toDouble(center)));
        corners_.push_back(corners);
        x_.push_back(center.x);
        y_.push_back(center.y);
        z_.push_back(center.z);
        radius_.push_back(float(radius * 1.0001));
    }
}

NearestPoint NearestSurface::nearest(Vec3 point) const {
    const std::size_t count = corners_.size();
    // 1. No triangle can be nearer than its sphere, and some point of it is no farther than its center.
    thread_local std::vector<float> least;
    least.resize(count);
    float bound = std::numeric_limits<float>::infinity();
    for (std::size_t t = 0; t < count; ++t) {
        const float x = x_[t] - point.x, y = y_[t] - point.y, z = z_[t] - point.z;
        const float d = std::sqrt(x * x + y * y + z * z);
        least[t] = d - radius_[t];
        bound = std::min(bound, d);
    }
    // 2. Only those that can be nearest are looked at. Of several at the same distance the first one wins.
    constexpr float kRounding = 1e-6f;  // of a float of size 1
    bound += kRounding;
    const Vec3d p = toDouble(point);
    NearestPoint best;
    double square = std::numeric_limits<double>::infinity();
    std::size_t winner = 0;
    for (std::size_t t = 0; t < count; ++t) {
        if (least[t] > bound) continue;
        const Vec3d q = nearestOnTriangle(p, corners_[t]);
        if (const double d = dot(q - p, q - p); d < square) {
            square = d;
            best.point = q;
            winner = t;
            bound = std::min(bound, float(std::sqrt(d)) + kRounding);
        }
    }
    const auto& [a, b, c] = corners_[winner];
    best.normal = normalized(cross(b - a, c - a));
    best.distance = std::sqrt(square);
    return best;
}

}  // namespace penumbra
