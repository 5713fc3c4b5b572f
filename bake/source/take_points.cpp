#include <limits>
#include <numeric>

#include "bake/source/choose_points.h"

namespace penumbra {

namespace {

// Returns for each vertex the least vertex that edges lead to. A hard edge has two rows of vertices, so that it ends a
// sheet.
std::vector<std::uint32_t> sheetsOf(const Mesh& mesh) {
    std::vector<std::uint32_t> parent(mesh.vertexCount());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : mesh.triangles)
        for (std::size_t i = 1; i < 3; ++i) {
            const std::uint32_t a = root(t[0]), b = root(t[i]);
            parent[std::max(a, b)] = std::min(a, b);
        }
    for (std::uint32_t v = 0; v < parent.size(); ++v) parent[v] = root(v);
    return parent;
}

// Returns the point that counts most for a vertex.
std::uint32_t nearestOf(const PointTable& points, std::size_t v) {
    const auto& w = points.weights[v];
    return points.corners[v][w[0] >= w[1] && w[0] >= w[2] ? 0 : w[1] >= w[2] ? 1 : 2];
}

}  // namespace

void takePoints(ChosenPoints chosen, VisibilityHeader& header) {
    DrawnMesh& drawn = *header.drawn;
    const Mesh& dense = drawn.mesh;
    const auto influences = std::size_t(drawn.skin.influences);
    header.mesh = Mesh{};
    header.rest_normals.clear();
    header.mesh.slots = dense.slots;
    header.skin = drawn.skin;
    header.skin->joints.clear();
    header.skin->weights.clear();
    const std::vector<std::uint32_t> sheet = sheetsOf(dense);
    Sheets sheets{{}, sheet};
    for (const std::uint32_t v : chosen.vertices) {
        header.mesh.rest_positions.push_back(dense.rest_positions[v]);
        header.rest_normals.push_back(drawn.rest_normals[v]);
        if (!dense.slots.empty()) header.mesh.slot_of_vertex.push_back(dense.slot_of_vertex[v]);
        for (std::size_t k = v * influences; k < (v + 1) * influences; ++k) {
            header.skin->joints.push_back(drawn.skin.joints[k]);
            header.skin->weights.push_back(drawn.skin.weights[k]);
        }
        sheets.from.push_back(sheet[v]);
    }
    header.mesh.triangles = std::move(chosen.triangles);
    PointDistances distances;
    drawn.points =
        nearestPoints({header.mesh, header.rest_normals}, {dense, drawn.rest_normals}, &sheets, 0, distances);
    for (const std::uint32_t v : dense.source_vertex) header.mesh.source_vertex.push_back(nearestOf(drawn.points, v));
    drawn.vertex_of_point = std::move(chosen.vertices);
}

}  // namespace penumbra
