#include "player/draw/closed_surfaces.h"

#include <algorithm>
#include <numeric>

#include "formats/common/disjoint_sets.h"

namespace penumbra {

namespace {

std::vector<std::uint32_t> surfaceOfVertex(std::span<const std::uint32_t> triangles, std::size_t vertices) {
    DisjointSets surfaces(vertices);
    for (std::size_t t = 0; t < triangles.size(); t += 3)
        for (const std::size_t corner : {t + 1, t + 2}) surfaces.join(triangles[corner], triangles[t]);
    return surfaces.names();
}

// Tells which surfaces are open. In a closed one, the two triangles at an edge run through it in opposite directions.
// So sorted by their vertices, the edges come in pairs with one of each direction.
std::vector<bool> openSurfaces(std::span<const std::uint32_t> triangles, const std::vector<std::uint32_t>& surface) {
    struct Edge {
        std::uint32_t low, high;
        bool upwards;
        auto operator<=>(const Edge&) const = default;
    };
    std::vector<Edge> edges;
    for (std::size_t t = 0; t < triangles.size(); t += 3)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = triangles[t + i], b = triangles[t + (i + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), a < b});
        }
    std::sort(edges.begin(), edges.end());
    std::vector<bool> open(surface.size());
    for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
        end = first;
        while (end < edges.size() && edges[end].low == edges[first].low && edges[end].high == edges[first].high) ++end;
        if (end - first != 2 || edges[first].upwards == edges[first + 1].upwards)
            open[surface[edges[first].low]] = true;
    }
    return open;
}

}  // namespace

ClosedSurfaces findClosedSurfaces(std::span<const std::uint32_t> triangles) {
    const std::size_t vertices = triangles.empty() ? 0 : *std::max_element(triangles.begin(), triangles.end()) + 1u;
    const std::vector<std::uint32_t> surface = surfaceOfVertex(triangles, vertices);
    const std::vector<bool> open = openSurfaces(triangles, surface);
    std::vector<std::uint32_t> order(triangles.size() / 3);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t t) {
        const std::uint32_t s = surface[triangles[3 * t]];
        return std::pair(bool(open[s]), open[s] ? 0 : s);
    };
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    ClosedSurfaces result;
    for (std::size_t i = 0; i < order.size(); ++i) {
        result.triangles.insert(result.triangles.end(), triangles.begin() + 3 * order[i],
                                triangles.begin() + 3 * order[i] + 3);
        if (key(order[i]).first) continue;
        if (i + 1 == order.size() || key(order[i + 1]) != key(order[i])) result.ends.push_back(3 * (i + 1));
    }
    return result;
}

bool allOutward(const ClosedSurfaces& surfaces, std::span<const Vec3> positions) {
    std::size_t at = 0;
    for (std::size_t end : surfaces.ends) {
        double volume = 0;  // 6 times the volume; about a point of the surface, for precision
        const Vec3 origin = positions[surfaces.triangles[at]];
        for (; at < end; at += 3) {
            const Vec3 a = positions[surfaces.triangles[at]] - origin,
                       b = positions[surfaces.triangles[at + 1]] - origin,
                       c = positions[surfaces.triangles[at + 2]] - origin;
            volume += double(dot(a, cross(b, c)));
        }
        if (volume <= 0) return false;
    }
    return true;
}

}  // namespace penumbra
