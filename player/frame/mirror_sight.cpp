#include "player/frame/mirror_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "formats/common/parallel_for.h"

namespace penumbra {

std::vector<float> mirrorSight(const Convention& convention, int stride, const FrameVertices& vertices, Vec3 eye,
                               int threads) {
    std::vector<float> sight(vertices.positions.size());
    const auto size = std::size_t(convention.size());
    const auto count = std::size_t(coefficientCount(convention.order));
    parallelFor(sight.size(), threads, [&](std::size_t v) {
        std::array<float, coefficientCount(kMaxOrder)> full, basis;
        const auto of = [&](std::array<float, coefficientCount(kMaxOrder)>& a) { return std::span(a).first(count); };
        fullCoefficients(convention, std::span(vertices.coefficients).subspan(v * std::size_t(stride), size), of(full));
        const Vec3 wo =
            toLocalFrame(vertices.normals[v], vertices.tangents[v]) * normalized(eye - vertices.positions[v]);
        evalBasis(convention.order, Vec3{-wo.x, -wo.y, std::abs(wo.z)}, of(basis));
        sight[v] = std::clamp(std::inner_product(basis.begin(), basis.begin() + count, full.begin(), 0.0f), 0.0f, 1.0f);
    });
    return sight;
}

std::vector<float> takeMirrorsOut(const Convention& convention, int stride, const FrameVertices& vertices, Vec3 eye,
                                  int threads, const LobeTable& table, std::span<const LobeRange> lobes,
                                  std::span<Vec3> values) {
    bool any = false;
    for (std::size_t v = 0; v < lobes.size(); ++v)  // the further terms of mirrors are 0 already
        if (table.isMirror(lobes[v])) {
            values[v] = {};
            any = true;
        }
    return any ? mirrorSight(convention, stride, vertices, eye, threads) : std::vector<float>();
}

}  // namespace penumbra
