#include "formats/common/mesh_places.h"

#include <algorithm>
#include <cassert>
#include <compare>
#include <numeric>

#include "formats/common/twin_triangles.h"

namespace penumbra {

std::vector<std::uint32_t> firstOfPlaces(std::span<const Vec3> rest_positions, const Skin& skin) {
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
        return 0;
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
    std::vector<std::uint32_t> first = firstOfPlaces(mesh.rest_positions, skin);
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
