#include "sh/vertex_normals.h"

#include <algorithm>
#include <cassert>
#include <optional>

namespace penumbra {

namespace {

Vec3d centroidOf(std::span<const Vec3> positions) {
    Vec3d centroid;
    for (Vec3 p : positions) centroid += toDouble(p) / double(positions.size());
    return centroid;
}

}  // namespace

void vertexNormals(std::span<const std::uint32_t> triangles, std::span<const Vec3> positions, std::span<Vec3d> scratch,
                   std::span<Vec3> normals) {
    assert(triangles.size() % 3 == 0 && scratch.size() == positions.size() && normals.size() == positions.size());
    // 1. Sum the normals, weighted by twice the areas.
    std::fill(scratch.begin(), scratch.end(), Vec3d{});
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
        const Vec3d a = toDouble(positions[triangles[t]]), b = toDouble(positions[triangles[t + 1]]),
                    c = toDouble(positions[triangles[t + 2]]);
        const Vec3d twice_area = cross(b - a, c - a);
        for (std::size_t corner = t; corner < t + 3; ++corner) scratch[triangles[corner]] += twice_area;
    }
    // 2. Normalise them, or find another one where there is no area.
    std::optional<Vec3d> centroid;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        Vec3d n = normalized(scratch[v]);
        if (n == Vec3d{}) {
            if (!centroid) centroid = centroidOf(positions);
            n = normalized(toDouble(positions[v]) - *centroid);
        }
        normals[v] = n == Vec3d{} ? Vec3{0, 1, 0} : toFloat(n);
    }
}

}  // namespace penumbra
