#include "bake/moments.h"

#include <cassert>

namespace penumbra {

std::size_t traceMoments(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         std::span<float> coefficients) {
    const RayDirections& directions = tracer.directions;
    const auto size = std::size_t(coefficientCount(directions.order));
    assert(positions.size() == normals.size() && coefficients.size() == positions.size() * size);
    std::vector<LaneWeights> rays(directions.packets.size());
    std::size_t traced = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        traced += aboveHorizon(directions, normals[v], tracer.ground, rays);
        tracer.scene.removeOccluded(tracer.scale.apply(positions[v]) + normals[v] * tracer.bias, directions, rays);
        accumulateMoments(directions, rays, coefficients.subspan(v * size, size));
    }
    return traced;
}

}  // namespace penumbra
