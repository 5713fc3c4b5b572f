#include "formats/common/mesh_places.h"

#include <algorithm>
#include <cassert>
#include <compare>
#include <numeric>
#include <tuple>

#include "formats/common/twin_triangles.h"

namespace penumbra {

namespace {

// The rows of morph targets in the order of vertices: those of vertex v are first[v] <= r < first[v + 1].
struct MovesOfVertices {
    std::vector<std::size_t> first;
    std::vector<std::pair<std::size_t, Vec3>> moves;  // a target, and what it adds to the vertex

    MovesOfVertices(const MorphTargets& morphs, std::size_t vertices) : first(vertices + 1, 0) {
        for (const std::uint32_t v : morphs.vertices) ++first[v + 1];
        std::partial_sum(first.begin(), first.end(), first.begin());
        moves.resize(morphs.vertices.size());
        std::vector<std::size_t> next = first;
        for (std::size_t target = 0; target < morphs.count(); ++target)
            for (std::size_t r = morphs.first[target]; r < morphs.first[target + 1]; ++r)
                moves[next[morphs.vertices[r]]++] = {target, morphs.positions[r]};
    }
    // Returns -1, 0 or 1 in some order of vertices.
    int compare(std::uint32_t a, std::uint32_t b) const {
        const auto order = [](const auto& m, const auto& n) {
            return std::tie(m.first, m.second.x, m.second.y, m.second.z) <
                   std::tie(n.first, n.second.x, n.second.y, n.second.z);
        };
        const auto begin_a = moves.begin() + std::ptrdiff_t(first[a]),
                   end_a = moves.begin() + std::ptrdiff_t(first[a + 1]);
        const auto begin_b = moves.begin() + std::ptrdiff_t(first[b]),
                   end_b = moves.begin() + std::ptrdiff_t(first[b + 1]);
        if (std::lexicographical_compare(begin_a, end_a, begin_b, end_b, order)) return -1;
        return std::lexicographical_compare(begin_b, end_b, begin_a, end_a, order) ? 1 : 0;
    }
};

}  // namespace

std::vector<std::uint32_t> firstOfPlaces(std::span<const Vec3> rest_positions, const Skin& skin,
                                         const MorphTargets& morphs) {
    const MovesOfVertices moved(morphs, rest_positions.size());
    const std::size_t k = skin.joints.empty() ? 0 : std::size_t(skin.influences);
    assert(skin.joints.size() == rest_positions.size() * k && skin.weights.size() == skin.joints.size());
    const auto compare = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3 p = rest_positions[a], q = rest_positions[b];
        if (p.x != q.x) return p.x < q.x ? -1 : 1;
        if (p.y != q.y) return p.y < q.y ? -1 : 1;
        if (p.z != q.z) return p.z < q.z ? -1 : 1;
        for (std::size_t i = 0; i < k; ++i) {
            if (skin.joints[a * k + i] != skin.joints[b * k + i])
                return skin.joints[a * k + i] < skin.joints[b * k + i] ? -1 : 1;
            if (skin.weights[a * k + i] != skin.weights[b * k + i])
                return skin.weights[a * k + i] < skin.weights[b * k + i] ? -1 : 1;
        }
        return moved.compare(a, b);
    };
    std::vector<std::uint32_t> order(rest_positions.size()), first(order.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const int way = compare(a, b);
        return way != 0 ? way < 0 : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && compare(order[i - 1], order[i]) == 0 ? first[order[i - 1]] : order[i];
    return first;
}

std::vector<std::uint32_t> firstOfSides(const Mesh& mesh, const Skin& skin) {
    std::vector<std::uint32_t> first = firstOfPlaces(mesh.rest_positions, skin, mesh.morphs);
    const std::vector<std::uint32_t> twins = twinTriangles(mesh, skin);
    if (twins.empty()) return first;
    const std::vector<std::uint32_t> traced = tracedVertices(mesh, twins);
    std::array<std::vector<std::uint32_t>, 2> first_of_side;
    for (std::vector<std::uint32_t>& of_side : first_of_side) of_side.assign(first.size(), UINT32_MAX);
    for (std::uint32_t v = 0; v < first.size(); ++v) {
        std::uint32_t& least = first_of_side[traced[v] == v ? 0 : 1][first[v]];
        least = std::min(least, v);
        first[v] = least;
    }
    return first;
}

std::vector<Triangle> trianglesOfPlaces(std::span<const Triangle> triangles, std::span<const std::uint32_t> first) {
    std::vector<Triangle> out(triangles.begin(), triangles.end());
    for (Triangle& t : out)
        for (std::uint32_t& corner : t) corner = first[corner];
    return out;
}

}  // namespace penumbra
