#include "player/composite/character_light.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <tuple>

namespace penumbra {

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
