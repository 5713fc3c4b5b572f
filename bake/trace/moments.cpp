#include "bake/trace/moments.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

float biasOf(const MomentTracer& tracer, std::size_t vertex) {
    return tracer.far_bias.empty() ? tracer.bias : tracer.far_bias[vertex % tracer.far_bias.size()];
}

RayStart startOfVertex(const MomentTracer& tracer, Vec3 position, Vec3 normal, std::size_t vertex) {
    const Vec3 scaled = tracer.scale.apply(position);
    const auto over_solid = [&] {
        return startOverSolid(scaled, tracer.start_ways.empty() ? normal : tracer.start_ways[vertex],
                              biasOf(tracer, vertex));
    };
    if (!tracer.blockers || dot(normal, normal) == 0) return over_solid();
    const std::uint32_t of_side = tracer.blockers->frontOf(std::uint32_t(vertex));
    const std::uint32_t front = tracer.blockers->placeOf(of_side);
    if (!tracer.blockers->startsOverSheet(front)) return over_solid();
    const Vec3 direction =
        directionToSide(tracer.blockers->fans, tracer.vertices, front, normal, vertex == of_side ? 1 : -1);
    return startOverSheet(
        tracer.scene, *tracer.blockers,
        {scaled, direction, biasOf(tracer, vertex), {front, front, front}, tracer.blockers->solid_of_vertex[front]});
}

namespace {

// The weights of the rays of one point at a time.
struct RayWeights {
    std::vector<LaneWeights> whole;  // rays that escape everything
    std::vector<LaneWeights> reach;  // lengths of the other rays, where they end
    std::vector<LaneWeights> near;   // rays that escape the local triangles
};

// Measures the moments of one point and its local ones. Returns the number of rays traced.
std::size_t traceBoth(const MomentTracer& tracer, const RayStart& start, Vec3 normal, std::size_t vertex,
                      RayWeights& rays, const MomentOutput& out) {
    const RayDirections& directions = tracer.directions;
    const LocalTriangles local = tracer.local->parts.ofVertex(vertex, tracer.local->part_boxes);
    // 1. A point that touches a local surface sees nothing. If the surface is not local, it blocks every ray of the
    // whole, and the local rays start as if it was not there.
    if (start.closed && local.contains(start.touching)) {
        std::fill(out.coefficients.begin(), out.coefficients.end(), 0.0f);
        std::fill(out.local.begin(), out.local.end(), 0.0f);
        return 0;
    }
    const float bias = biasOf(tracer, vertex);
    const Vec3 origin = start.closed ? startOverSolid(start.position, normal, bias).position : start.position;
    // 2. The floor is not local, so the local rays go below it.
    (void)aboveHorizon(directions, normal, Floor::kNone, rays.near);
    std::size_t traced = 0;
    if (start.closed)
        std::fill(rays.whole.begin(), rays.whole.end(), LaneWeights{});
    else
        traced = aboveHorizon(directions, normal, tracer.floor, rays.whole);
    // 3. Trace, and sum each basis over the rays that are left.
    tracer.scene.removeOccludedLocally(origin, directions, local, rays.whole, rays.near);
    accumulateMoments(directions, rays.whole, out.coefficients);
    accumulateMoments(tracer.local->directions, rays.near, out.local);
    return traced;
}

}  // namespace

namespace {

// Drops the rays of a point that meet an occluder before their ends. Returns how many there were.
std::size_t traceWithin(const MomentTracer& tracer, Vec3 position, Vec3 normal, std::size_t vertex, RayWeights& rays) {
    const RayDirections& directions = tracer.directions;
    const std::size_t traced = aboveHorizon(directions, normal, Floor::kNone, rays.whole);
    const float height = position.y - tracer.floor_y;
    for (std::size_t p = 0; p < rays.whole.size(); ++p) {
        rays.reach[p] = tracer.reach->of(p, std::uint32_t(vertex));
        if (tracer.floor == Floor::kNone) continue;
        const std::array<float, kLanes>& y = directions.packets[p].y;
        for (std::size_t k = 0; k < kLanes; ++k)
            if (y[k] < 0 && height < -y[k] * rays.reach[p].lane[k]) rays.whole[p].lane[k] = 0;
    }
    tracer.scene.removeOccluded(position, directions, rays.whole, rays.reach);
    return traced;
}

}  // namespace

std::size_t traceMoments(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const MomentOutput& out, std::size_t first_vertex) {
    const RayDirections& directions = tracer.directions;
    const auto size = std::size_t(coefficientCount(directions.order));
    const std::size_t local_size = tracer.local ? std::size_t(coefficientCount(tracer.local->directions.order)) : 0;
    assert(positions.size() == normals.size() && out.coefficients.size() == positions.size() * size);
    assert(out.local.size() == positions.size() * local_size);
    assert(!tracer.reach || !tracer.local);
    RayWeights rays{std::vector<LaneWeights>(directions.packets.size()), {}, {}};
    if (tracer.reach) rays.reach.resize(directions.packets.size());
    if (tracer.local) rays.near.resize(directions.packets.size());
    std::size_t traced = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const std::span<float> whole = out.coefficients.subspan(v * size, size);
        const std::size_t vertex = tracer.vertexOf(first_vertex + v);
        const RayStart start = startOfVertex(tracer, positions[v], normals[v], vertex);
        if (tracer.local) {
            const std::span<float> near = out.local.subspan(v * local_size, local_size);
            traced += traceBoth(tracer, start, normals[v], vertex, rays, {whole, near});
            continue;
        }
        // 1. A point that touches another surface sees nothing.
        if (start.closed) {
            std::fill(whole.begin(), whole.end(), 0.0f);
            continue;
        }
        // 2. Choose the directions above the horizon, drop the blocked ones, and sum the basis over those that are
        // left.
        if (tracer.reach) {
            traced += traceWithin(tracer, start.position, normals[v], vertex, rays);
        } else {
            traced += aboveHorizon(directions, normals[v], tracer.floor, rays.whole);
            tracer.scene.removeOccluded(start.position, directions, rays.whole);
        }
        accumulateMoments(directions, rays.whole, whole);
    }
    return traced;
}

}  // namespace penumbra
