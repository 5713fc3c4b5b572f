#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "bake/source/choose_points.h"
#include "formats/common/disjoint_sets.h"

namespace penumbra {

namespace {

// Returns for each vertex the first one that differs from it in its slot alone. Places of several slots have a vertex
// of each.
std::vector<std::uint32_t> firstAcrossSlots(const DrawnMesh& drawn) {
    const Mesh& mesh = drawn.mesh;
    std::vector<std::uint32_t> first(mesh.vertexCount()), order(first.size());
    std::iota(first.begin(), first.end(), 0u);
    if (mesh.slots.size() < 2) return first;
    const auto influences = std::size_t(drawn.skin.influences);
    const auto numbersOf = [&](std::uint32_t v) {
        const Vec3 p = mesh.rest_positions[v], n = drawn.rest_normals[v];
        return std::array{p.x, p.y, p.z, n.x, n.y, n.z};
    };
    const auto rowsOf = [&](const auto& rows, std::uint32_t v) {
        return std::span(rows).subspan(v * influences, influences);
    };
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
        const auto x = numbersOf(a), y = numbersOf(b);
        if (x != y) return x < y;
        const auto j = rowsOf(drawn.skin.joints, a), k = rowsOf(drawn.skin.joints, b);
        if (!std::ranges::equal(j, k)) return std::ranges::lexicographical_compare(j, k);
        return std::ranges::lexicographical_compare(rowsOf(drawn.skin.weights, a), rowsOf(drawn.skin.weights, b));
    };
    order = first;
    std::stable_sort(order.begin(), order.end(), less);
    for (std::size_t i = 1; i < order.size(); ++i)
        if (!less(order[i - 1], order[i])) first[order[i]] = first[order[i - 1]];
    return first;
}

// Returns the point that counts most for a vertex.
std::uint32_t nearestOf(const PointTable& points, std::size_t v) {
    const auto& w = points.weights[v];
    return points.corners[v][w[0] >= w[1] && w[0] >= w[2] ? 0 : w[1] >= w[2] ? 1 : 2];
}

}  // namespace

std::vector<Triangle> trianglesAcrossSlots(const DrawnMesh& drawn) {
    const std::vector<std::uint32_t> first = firstAcrossSlots(drawn);
    std::vector<Triangle> triangles = drawn.mesh.triangles;
    for (Triangle& t : triangles)
        for (std::uint32_t& v : t) v = first[v];
    return triangles;
}

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
    // A hard edge has two rows of vertices, so that it ends a sheet.
    std::vector<std::uint32_t> sheet = connectedParts(trianglesAcrossSlots(drawn), dense.vertexCount());
    const std::vector<std::uint32_t> first = firstAcrossSlots(drawn);
    for (std::size_t v = 0; v < sheet.size(); ++v) sheet[v] = sheet[first[v]];
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
    header.mesh.morphs = selectVertices(dense.morphs, chosen.vertices);
    PointDistances distances;
    drawn.points =
        nearestPoints({header.mesh, header.rest_normals}, {dense, drawn.rest_normals}, &sheets, 0, distances);
    for (const std::uint32_t v : dense.source_vertex) header.mesh.source_vertex.push_back(nearestOf(drawn.points, v));
    drawn.vertex_of_point = std::move(chosen.vertices);
}

}  // namespace penumbra
