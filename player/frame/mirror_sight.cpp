#include "player/frame/mirror_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "formats/common/parallel_for.h"

namespace penumbra {

std::vector<float> mirrorSight(const ModelView& model, const FrameVertices& vertices, Vec3 eye, int threads) {
    std::vector<float> sight(vertices.positions.size());
    const auto stride = std::size_t(model.stride), size = std::size_t(model.convention.size());
    const auto count = std::size_t(coefficientCount(model.convention.order));
    parallelFor(sight.size(), threads, [&](std::size_t v) {
        std::array<float, coefficientCount(kMaxOrder)> coefficients, basis;
        const auto of = [&](std::array<float, coefficientCount(kMaxOrder)>& a) { return std::span(a).first(count); };
        toCoefficients(model.convention, std::span(vertices.numbers).subspan(v * stride, size), of(coefficients));
        const Vec3 wo =
            toLocalFrame(vertices.normals[v], vertices.tangents[v]) * normalized(eye - vertices.positions[v]);
        evalBasis(model.convention.order, Vec3{-wo.x, -wo.y, std::abs(wo.z)}, of(basis));
        sight[v] = std::clamp(std::inner_product(basis.begin(), basis.begin() + count, coefficients.begin(), 0.0f),
                              0.0f, 1.0f);
    });
    return sight;
}

std::vector<float> takeMirrorsOut(const ModelView& model, const FrameVertices& vertices, Vec3 eye, int threads,
                                  const LobeTable& table, std::span<const LobeRange> lobes, std::span<Vec3> values) {
    bool any = false;
    for (std::size_t v = 0; v < values.size(); ++v)
        if (table.isMirror(lobes[v])) {
            values[v] = {};
            any = true;
        }
    return any ? mirrorSight(model, vertices, eye, threads) : std::vector<float>();
}

}  // namespace penumbra
