#pragma once
// The two sides of a sheet in an asset, whose vertices are in cluster order.
#include <cstdint>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// Returns the vertex of the other side of each vertex, [V]; of a one-sided mesh the vertex itself.
inline std::vector<std::uint32_t> otherSides(const MeshView& mesh) {
    const std::size_t vertices = mesh.positions.size(), points = mesh.pointCount();
    std::vector<std::uint32_t> vertex_of_point(vertices), other(vertices);
    for (std::uint32_t v = 0; v < vertices; ++v) vertex_of_point[mesh.shading_point[v]] = v;
    for (std::uint32_t v = 0; v < vertices; ++v)
        other[v] = !mesh.two_sided  ? v
                   : mesh.isBack(v) ? vertex_of_point[mesh.pointOf(v)]
                                    : vertex_of_point[mesh.pointOf(v) + points];
    return other;
}

}  // namespace penumbra
