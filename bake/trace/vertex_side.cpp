// Finds a direction from a vertex of a crumpled sheet that really leads to the wanted side.
//
// Problem: the rays of a vertex start a little way off the sheet on one side (ray_start.h). Which way is that side?
//
// Naive: take the vertex normal. It is the mean of the normals around the vertex. Where the sheet folds sharply at
// the vertex, the mean of the normals may point through one of the triangles, and the rays start on the wrong side of
// it.
//
// Here: first test whether the normal is on the wanted side, which nearly always is so. A direction is on the front
// side if the front of the nearest triangle faces it. Distances are angles, since only directions from one vertex are
// compared. If the nearest point lies on the edge of two triangles, neither normal alone decides correctly, but their
// sum does. Where the normal fails, try the normals of the triangles and the means of neighbours, and take the one
// with most space around it. The direction is used by the rules of ray_start.cpp; section 2 of docs/formulas.md
// defines what the rays measure.
#include "bake/trace/vertex_side.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

VertexFans makeFans(std::span<const Triangle> triangles, std::size_t vertices) {
    // A counting sort: count the triangles of each vertex, sum the counts up, then put each triangle in its place.
    VertexFans fans{std::vector<std::uint32_t>(vertices + 1), {}};
    for (const Triangle& t : triangles)
        for (const std::uint32_t corner : t) ++fans.begin[corner + 1];
    for (std::size_t v = 0; v < vertices; ++v) fans.begin[v + 1] += fans.begin[v];
    fans.corners.resize(3 * triangles.size());
    std::vector<std::uint32_t> next(fans.begin.begin(), fans.begin.end() - 1);
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) fans.corners[next[t[k]]++] = {t[(k + 1) % 3], t[(k + 2) % 3]};
    return fans;
}

namespace {

constexpr double kNearlyInFace = 1e-6;  // a squared sine

// A triangle as the vertex sees it: a sector of the directions between two of its edges.
struct Sector {
    std::array<std::uint32_t, 2> corners;  // the other two vertices of the triangle
    std::array<Vec3d, 2> edges;            // unit, from the vertex to these two
    Vec3d normal;                          // unit, of the wanted side
};

std::vector<Sector> sectorsOf(const VertexFans& fans, std::span<const Vec3> positions, std::uint32_t vertex, int side) {
    std::vector<Sector> sectors;
    const Vec3d p = toDouble(positions[vertex]);
    for (std::uint32_t i = fans.begin[vertex]; i < fans.begin[vertex + 1]; ++i) {
        const auto [a, b] = fans.corners[i];
        const Vec3d to_a = normalized(toDouble(positions[a]) - p), to_b = normalized(toDouble(positions[b]) - p);
        const Vec3d normal = normalized(cross(to_a, to_b)) * double(side);
        // triangles without area have no side
        if (dot(normal, normal) > 0) sectors.push_back({{a, b}, {to_a, to_b}, normal});
    }
    return sectors;
}

// Returns the sum of the normals of both triangles at the edge to `corner`.
Vec3d edgeNormal(const std::vector<Sector>& sectors, std::uint32_t corner) {
    Vec3d sum;
    for (const Sector& s : sectors)
        if (s.corners[0] == corner || s.corners[1] == corner) sum += s.normal;
    return sum;
}

// Tells whether a vector of the sector's plane points between the sector's two edges.
bool within(const Sector& sector, Vec3d in_plane) {
    const Vec3d outward = cross(sector.edges[0], sector.edges[1]);
    return dot(cross(sector.edges[0], in_plane), outward) >= 0 && dot(cross(in_plane, sector.edges[1]), outward) >= 0;
}

// Returns the squared sine of the angle to the nearest triangle, 1 beyond a right angle. It is negative on the wrong
// side.
double clearance(const std::vector<Sector>& sectors, Vec3d direction, Vec3d normal) {
    // Where all triangles are more than a right angle away, the vertex normal tells the side.
    double nearest = 1, sign = dot(direction, normal);
    for (const Sector& sector : sectors) {
        // Inside of the sector the nearest point is the direction's projection on the triangle's plane.
        const double height = dot(direction, sector.normal);
        if (within(sector, direction - sector.normal * height)) {
            if (height * height >= nearest) continue;
            nearest = height * height;
            sign = height;
            continue;
        }
        // Outside of it the nearest point lies on one of the two edges, unless the edge points away.
        for (std::size_t k = 0; k < 2; ++k) {
            const double along = dot(direction, sector.edges[k]);
            if (along <= 0 || 1 - along * along >= nearest) continue;
            nearest = 1 - along * along;
            sign = dot(direction, edgeNormal(sectors, sector.corners[k]));
        }
    }
    return sign > 0 ? nearest : -nearest;
}

}  // namespace

Vec3 directionToSide(const VertexFans& fans, std::span<const Vec3> positions, std::uint32_t vertex, Vec3 normal,
                     int side) {
    const Vec3d wanted = toDouble(normal);
    const std::vector<Sector> sectors = sectorsOf(fans, positions, vertex, side);
    // 1. The normal will do where it faces every triangle, and where the test finds it on the right side.
    const auto facesUs = [&](const Sector& s) { return dot(s.normal, wanted) > 0; };
    if (std::all_of(sectors.begin(), sectors.end(), facesUs) || clearance(sectors, wanted, wanted) > 0) return normal;
    // 2. Otherwise take the candidate on the right side that has the most space. `normal` stays where no candidate
    // is.
    Vec3d best = wanted;
    double most = 0;
    const auto consider = [&](Vec3d direction) {
        const double found = clearance(sectors, direction, wanted);
        if (found <= most) return;
        most = found;
        best = direction;
    };
    Vec3d sum;
    for (const Sector& a : sectors) {
        sum += a.normal;
        consider(a.normal);
        for (const Sector& b : sectors)
            if (a.corners[1] == b.corners[0])
                if (const Vec3d mean = normalized(a.normal + b.normal); dot(mean, mean) > 0) consider(mean);
    }
    // Where three faces meet in a corner the other candidates lie in the third face.
    if (const Vec3d mean = normalized(sum); most < kNearlyInFace && dot(mean, mean) > 0) consider(mean);
    return toFloat(best);
}

}  // namespace penumbra
