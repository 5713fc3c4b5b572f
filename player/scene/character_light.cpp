#include "player/scene/character_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <numbers>
#include <tuple>

namespace penumbra {

namespace {

// Vertices from one that stands for all to the next.
std::size_t shiningStep(std::size_t vertices) {
    constexpr std::size_t kMax = 2000;  // vertices of a mesh that are looked at
    return vertices / kMax + 1;
}

}  // namespace

std::vector<std::uint32_t> shiningVertices(std::size_t vertices, std::span<const std::uint16_t> slot_of_vertex) {
    std::vector<std::uint32_t> out;
    for (std::size_t v = 0; v < vertices; v += shiningStep(vertices)) out.push_back(std::uint32_t(v));
    if (!slot_of_vertex.empty()) std::ranges::stable_sort(out, {}, [&](std::uint32_t v) { return slot_of_vertex[v]; });
    return out;
}

void addShining(const ShiningMesh& mesh, std::vector<ShiningVertex>& vertices) {
    thread_local std::vector<float> areas;
    areas.assign(mesh.positions.size(), 0.0f);
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
        const Vec3 a = mesh.positions[mesh.triangles[t]], b = mesh.positions[mesh.triangles[t + 1]],
                   c = mesh.positions[mesh.triangles[t + 2]];
        const float third = length(cross(b - a, c - a)) / 6;
        for (std::size_t k = 0; k < 3; ++k) areas[mesh.triangles[t + k]] += third;
    }
    const std::size_t step = shiningStep(areas.size());
    for (std::size_t v = 0; v < areas.size(); v += step)
        vertices.push_back({mesh.positions[v], mesh.normals[v] * (areas[v] * float(step)), mesh.radiance[v]});
}

void emittersOf(std::span<const ShiningVertex> vertices, float cell, std::vector<Emitter>& out) {
    struct Placed {
        std::tuple<int, int, int, int> cell;  // cell of space, and the octant of the normal
        std::size_t vertex;
    };
    thread_local std::vector<Placed> placed;
    placed.clear();
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const Vec3 at = vertices[v].position / cell, area = vertices[v].area;
        if (!(length(area) > 0)) continue;
        const int octant = (area.x > 0 ? 1 : 0) + (area.y > 0 ? 2 : 0) + (area.z > 0 ? 4 : 0);
        placed.push_back({{int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z)), octant}, v});
    }
    std::ranges::sort(placed, [](const Placed& a, const Placed& b) {
        return a.cell != b.cell ? a.cell < b.cell : a.vertex < b.vertex;
    });
    out.clear();
    for (std::size_t first = 0; first < placed.size();) {
        Emitter sum = {};
        float weights = 0;
        const std::size_t begin = first;
        for (; first < placed.size() && placed[first].cell == placed[begin].cell; ++first) {
            const ShiningVertex& v = vertices[placed[first].vertex];
            const float weight = length(v.area);
            sum.position += v.position * weight;
            sum.area += v.area;
            sum.radiance += v.radiance * weight;
            weights += weight;
        }
        out.push_back({sum.position / weights, sum.area, sum.radiance / weights});
    }
}

Vec3 meanRadiance(std::span<const Emitter> emitters, Vec3 point, Vec3 normal) {
    Vec3 sum;
    float total = 0;
    for (const Emitter& emitter : emitters) {
        const Vec3 way = emitter.position - point;
        const float above = dot(way, normal), front = -dot(way, emitter.area), square = dot(way, way);
        if (above <= 0 || front <= 0) continue;
        // Cosines at both ends over the square of the distance, which is kept from 0 by the emitter's own size.
        const float near = square + length(emitter.area) / std::numbers::pi_v<float>;
        const float share = above * front / (near * near);
        sum += emitter.radiance * share;
        total += share;
    }
    return total > 0 ? sum / total : Vec3{};
}

}  // namespace penumbra
