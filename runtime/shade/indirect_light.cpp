#include "runtime/shade/indirect_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/far/far_visibility.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

// Band 1 is a vector: y_1 = sqrt(3/4pi) (-y, z, -x). Band 2 is a quadratic form s^T M s with M symmetric and without
// trace, and the integral of the product of two such forms over the sphere is 8 pi / 15 tr(M M').
std::array<Vec3, kBouncedLight> makeBouncedLight(const ColorAxes& axes,
                                                 std::span<const Vec3, kIndirectCoefficients> light) {
    const auto xy = float(std::sqrt(15 / (16 * std::numbers::pi))), zz = float(std::sqrt(5 / (16 * std::numbers::pi))),
               norm = float(8 * std::numbers::pi / 15);
    const auto& l = light;
    const std::array<Vec3, 10> plain{
        l[0],
        -l[3],
        -l[1],
        l[2],
        norm * (xy * l[8] - zz * l[6]),
        norm * (-xy * l[8] - zz * l[6]),
        norm * (2 * zz) * l[6],
        2 * norm * xy * l[4],  // xy stands twice in the matrix
        -2 * norm * xy * l[7],
        -2 * norm * xy * l[5],
    };
    std::array<Vec3, kBouncedLight> out;
    const auto axis = [&](int k) { return Vec3{axes(k, 0), axes(k, 1), axes(k, 2)}; };
    for (std::size_t i = 0; i < plain.size(); ++i) out[i] = plain[i] * axis(0);
    out[10] = l[0] * axis(1);
    out[11] = l[0] * axis(2);
    return out;
}

Vec3 bouncedAmbientWeights(const ColorAxes& axes) {
    const auto scale = float(2 * std::numbers::inv_sqrtpi);  // sqrt(4 pi) / pi
    Vec3 weights;
    for (int k = 0; k < 3; ++k) weights[k] = scale * luminance(Vec3{axes(k, 0), axes(k, 1), axes(k, 2)});
    return weights;
}

void addBouncedAmbient(const ColorAxes& axes, std::span<const float> indirect, std::span<float> e) {
    assert(indirect.size() == e.size() * kIndirectStride);
    const Vec3 weights = bouncedAmbientWeights(axes);
    for (std::size_t v = 0; v < e.size(); ++v) {
        const float* n = indirect.data() + v * kIndirectStride;
        const float bounced =
            weights.x * n[0] + weights.y * n[kIndirectCoefficients] + weights.z * n[kIndirectCoefficients + 1];
        e[v] = std::clamp(e[v] + bounced, 0.0f, 1.0f);
    }
}

void castOnIndirect(std::span<const float> mirrored, std::span<float> indirect) {
    std::array<float, kFarCoefficients> weights;
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    assert(mirrored.size() / kFarCoefficients == indirect.size() / kIndirectStride);
    for (std::size_t v = 0; v < mirrored.size() / kFarCoefficients; ++v) {
        float share = 0;
        for (std::size_t i = 0; i < kFarCoefficients; ++i) share += weights[i] * mirrored[v * kFarCoefficients + i];
        share = std::clamp(share, 0.0f, 1.0f);
        for (float& x : indirect.subspan(v * kIndirectStride, kIndirectStride)) x *= share;
    }
}

}  // namespace penumbra
