#include "bake/moments.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

namespace {

// Returns where the rays of a point start: at the bias along the normal, or by the rules for sheets where these
// apply. A vertex v of the back has the front vertex v - frontVertexCount().
RayStart startOfVertex(const MomentTracer& tracer, Vec3 position, Vec3 normal, std::size_t vertex) {
    const Vec3 scaled = tracer.scale.apply(position);
    if (!tracer.blockers || dot(normal, normal) == 0) return startOverSolid(scaled, normal, tracer.bias);
    const std::size_t fronts = tracer.mesh->frontVertexCount();
    const auto front = std::uint32_t(vertex % fronts);
    const Vec3 direction =
        directionToSide(tracer.blockers->fans, tracer.vertices, front, normal, vertex < fronts ? 1 : -1);
    return startOverSheet(
        tracer.scene, *tracer.blockers,
        {scaled, direction, tracer.bias, {front, front, front}, tracer.blockers->solid_of_vertex[front]});
}

}  // namespace

std::size_t traceMoments(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         std::span<float> coefficients, std::size_t first_vertex) {
    const RayDirections& directions = tracer.directions;
    const auto size = std::size_t(coefficientCount(directions.order));
    assert(positions.size() == normals.size() && coefficients.size() == positions.size() * size);
    std::vector<LaneWeights> rays(directions.packets.size());
    std::size_t traced = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const std::span<float> out = coefficients.subspan(v * size, size);
        const RayStart start = startOfVertex(tracer, positions[v], normals[v], first_vertex + v);
        // 1. A point that touches another surface sees nothing.
        if (start.closed) {
            std::fill(out.begin(), out.end(), 0.0f);
            continue;
        }
        // 2. Choose the directions above the horizon, drop the blocked ones, and sum the basis over those that are
        // left.
        traced += aboveHorizon(directions, normals[v], tracer.ground, rays);
        tracer.scene.removeOccluded(start.position, directions, rays);
        accumulateMoments(directions, rays, out);
    }
    return traced;
}

}  // namespace penumbra
