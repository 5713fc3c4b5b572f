#include "bake/trace/start_ways.h"

#include <cassert>

namespace penumbra {

namespace {

constexpr float kOpposite = -0.98f;  // cosine of 168.5 degrees
constexpr double kMinRise = 0.1;     // sine of the least angle between the way and the point's own plane

}  // namespace

std::vector<Vec3> startWays(std::span<const std::uint32_t> first, std::span<const Vec3> normals) {
    assert(first.size() == normals.size());
    // 1. The vertices of each place in a ring: `next` leads from each to another of the same place.
    std::vector<std::uint32_t> next(first.size());
    for (std::uint32_t v = 0; v < first.size(); ++v) {
        next[v] = v;
        if (first[v] != v) std::swap(next[v], next[first[v]]);
    }
    // 2. Sums, from each vertex once round its ring. A place has few points.
    std::vector<Vec3> ways(normals.begin(), normals.end());
    for (std::uint32_t v = 0; v < first.size(); ++v) {
        if (next[v] == v) continue;
        Vec3d sum = toDouble(normals[v]);
        for (std::uint32_t other = next[v]; other != v; other = next[other])
            if (dot(normals[v], normals[other]) > kOpposite) sum += toDouble(normals[other]);
        const Vec3d way = normalized(sum);
        if (dot(way, toDouble(normals[v])) >= kMinRise) ways[v] = toFloat(way);
    }
    return ways;
}

}  // namespace penumbra
