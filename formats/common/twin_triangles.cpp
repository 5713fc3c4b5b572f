#include "formats/common/twin_triangles.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <unordered_map>

namespace penumbra {

namespace {

// Numbers the places of vertices: those with the same bytes of position and of skin, if there is one, have one number.
std::vector<std::uint32_t> placesOf(std::span<const Vec3> positions, const Skin* skin) {
    std::unordered_map<std::string, std::uint32_t> number;
    std::vector<std::uint32_t> places;
    std::string key;
    const auto add = [&key](const void* from, std::size_t size) { key.append(static_cast<const char*>(from), size); };
    for (std::size_t v = 0; v < positions.size(); ++v) {
        key.clear();
        const Vec3 p = positions[v] + Vec3{};  // -0 becomes 0
        add(&p, sizeof p);
        if (skin) {
            const std::size_t k = std::size_t(skin->influences);
            add(skin->joints.data() + v * k, k * sizeof(std::uint16_t));
            add(skin->weights.data() + v * k, k * sizeof(float));
        }
        places.push_back(number.try_emplace(key, std::uint32_t(number.size())).first->second);
    }
    return places;
}

struct TriangleHash {
    std::size_t operator()(const Triangle& t) const {
        return std::size_t(t[0]) * 73856093u ^ std::size_t(t[1]) * 19349663u ^ std::size_t(t[2]) * 83492791u;
    }
};

// Turns a triangle so that its least number comes first. It keeps the side that it faces.
Triangle turned(Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
}

std::vector<std::uint32_t> twinsAt(std::span<const Triangle> triangles, std::span<const std::uint32_t> places) {
    std::vector<std::uint32_t> twins(triangles.size());
    std::iota(twins.begin(), twins.end(), 0u);
    std::unordered_map<Triangle, std::vector<std::uint32_t>, TriangleHash> alone;  // by the places of their corners
    bool any = false;
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
        const auto [a, b, c] = triangles[t];
        const Triangle front = turned({places[a], places[b], places[c]});
        const auto behind = alone.find({front[0], front[2], front[1]});
        if (behind == alone.end() || behind->second.empty()) {
            alone[front].push_back(t);
            continue;
        }
        twins[t] = behind->second.front();
        twins[twins[t]] = t;
        behind->second.erase(behind->second.begin());
        any = true;
    }
    return any ? twins : std::vector<std::uint32_t>{};
}

}  // namespace

std::vector<std::uint32_t> twinTriangles(const Mesh& mesh, const Skin& skin) {
    return twinsAt(mesh.triangles, placesOf(mesh.rest_positions, &skin));
}

std::vector<std::uint32_t> twinsByPlace(std::span<const Triangle> triangles, std::span<const Vec3> rest_positions) {
    return twinsAt(triangles, placesOf(rest_positions, nullptr));
}

Triangle twinCorners(const Mesh& mesh, std::size_t triangle, std::size_t twin) {
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k)
        for (const std::uint32_t corner : mesh.triangles[twin])
            if (mesh.rest_positions[corner] == mesh.rest_positions[mesh.triangles[triangle][k]]) out[k] = corner;
    return out;
}

std::vector<std::uint32_t> tracedVertices(const Mesh& mesh, std::span<const std::uint32_t> twins) {
    std::vector<std::uint32_t> front(mesh.vertexCount());
    std::iota(front.begin(), front.end(), 0u);
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
        if (twins[t] >= t) continue;
        const Triangle traced = twinCorners(mesh, t, twins[t]);
        for (std::size_t k = 0; k < 3; ++k) front[mesh.triangles[t][k]] = traced[k];
    }
    for (std::uint32_t t = 0; t < twins.size(); ++t)
        for (const std::uint32_t corner : mesh.triangles[t])
            if (twins[t] >= t) front[corner] = corner;
    return front;
}

std::vector<std::uint32_t> twinVertices(const Mesh& mesh, std::span<const std::uint32_t> twins) {
    std::vector<std::uint32_t> other(mesh.vertexCount());
    std::iota(other.begin(), other.end(), 0u);
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
        if (twins[t] == t) continue;
        const Triangle behind = twinCorners(mesh, t, twins[t]);
        for (std::size_t k = 0; k < 3; ++k) other[mesh.triangles[t][k]] = behind[k];
    }
    return other;
}

}  // namespace penumbra
