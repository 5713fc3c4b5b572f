#include "sh/dihedral_angles.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

// An edge as seen from one of its triangles.
struct HalfEdge {
    std::uint32_t a, b;  // a < b
    bool forward;        // true when the triangle has it as a -> b
    std::uint32_t opposite;
};

}  // namespace

std::vector<InnerEdge> innerEdges(std::span<const std::array<std::uint32_t, 3>> triangles) {
    // 1. Collect the edges of all triangles, and sort those of one edge together.
    std::vector<HalfEdge> halves;
    halves.reserve(3 * triangles.size());
    for (const auto& t : triangles) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = t[k], to = t[(k + 1) % 3];
            halves.push_back({std::min(from, to), std::max(from, to), from < to, t[(k + 2) % 3]});
        }
    }
    std::sort(halves.begin(), halves.end(), [](const HalfEdge& p, const HalfEdge& q) {
        return std::array{p.a, p.b, std::uint32_t(!p.forward), p.opposite} <
               std::array{q.a, q.b, std::uint32_t(!q.forward), q.opposite};
    });
    // 2. Keep the edges with exactly two triangles in opposite directions.
    std::vector<InnerEdge> edges;
    for (std::size_t begin = 0, end = 0; begin < halves.size(); begin = end) {
        while (end < halves.size() && halves[end].a == halves[begin].a && halves[end].b == halves[begin].b) ++end;
        if (end - begin == 2 && halves[begin].forward && !halves[begin + 1].forward)
            edges.push_back({halves[begin].a, halves[begin].b, halves[begin].opposite, halves[begin + 1].opposite});
    }
    return edges;
}

void dihedralAngles(std::span<const InnerEdge> edges, std::span<const Vec3> positions, std::span<float> angles) {
    assert(angles.size() == edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const Vec3d a = toDouble(positions[edges[e][0]]), edge = toDouble(positions[edges[e][1]]) - a;
        const Vec3d n1 = cross(edge, toDouble(positions[edges[e][2]]) - a);
        const Vec3d n2 = cross(toDouble(positions[edges[e][3]]) - a, edge);
        // n1 x n2 lies along the edge, so the two arguments are sin and cos of the angle times |edge| |n1| |n2|.
        angles[e] = float(std::atan2(dot(cross(n1, n2), edge), dot(n1, n2) * length(edge)));
    }
}

int turnsTowards(float before, float angle) {
    return int(std::lround((double(before) - double(angle)) / (2 * std::numbers::pi)));
}

float addTurns(float angle, int turns) { return float(double(angle) + turns * (2 * std::numbers::pi)); }

}  // namespace penumbra
