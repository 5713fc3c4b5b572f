#include "player/scene/character_light.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <tuple>

namespace penumbra {

void addShining(const ShiningMesh& mesh, std::vector<ShiningVertex>& vertices) {
    constexpr std::size_t kMax = 2000;  // vertices of a mesh that are looked at
    std::vector<float> areas(mesh.positions.size());
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
        const Vec3 a = mesh.positions[mesh.triangles[t]], b = mesh.positions[mesh.triangles[t + 1]],
                   c = mesh.positions[mesh.triangles[t + 2]];
        const float third = length(cross(b - a, c - a)) / 6;
        for (std::size_t k = 0; k < 3; ++k) areas[mesh.triangles[t + k]] += third;
    }
    const std::size_t step = areas.size() / kMax + 1;
    for (std::size_t v = 0; v < areas.size(); v += step)
        vertices.push_back({mesh.positions[v], mesh.normals[v] * (areas[v] * float(step)), mesh.radiance[v]});
}

std::vector<Emitter> emittersOf(std::span<const ShiningVertex> vertices, float cell) {
    struct Sum {
        Vec3 position, area, radiance;
        float weight = 0;
    };
    std::map<std::tuple<int, int, int, int>, Sum> cells;
    for (const ShiningVertex& v : vertices) {
        const float weight = length(v.area);
        if (!(weight > 0)) continue;
        const Vec3 at = v.position / cell;
        const int octant = (v.area.x > 0 ? 1 : 0) + (v.area.y > 0 ? 2 : 0) + (v.area.z > 0 ? 4 : 0);
        Sum& sum = cells[{int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z)), octant}];
        sum.position += v.position * weight;
        sum.area += v.area;
        sum.radiance += v.radiance * weight;
        sum.weight += weight;
    }
    std::vector<Emitter> out;
    for (const auto& [key, sum] : cells)
        out.push_back({sum.position / sum.weight, sum.area, sum.radiance / sum.weight});
    return out;
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
