#include "player/papers/sphere_cast.h"

#include <algorithm>
#include <array>

#include "formats/common/parallel_for.h"
#include "runtime/shade/shading.h"
#include "sh/quadrature.h"
#include "sh/reflectance.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

constexpr std::size_t kReferencePiece = 64, kFieldPiece = 512;  // receivers that a thread takes at once

// Moments over the upper hemisphere of mirrored functions: [order^2, kFarCoefficients].
std::vector<float> momentMatrix(int order) {
    const std::size_t n = std::size_t(coefficientCount(order));
    const std::vector<int> even = evenIndices(kFieldOrder);
    std::vector<double> y(kFieldCoefficients), sum(n * kFarCoefficients);
    for (const WeightedDirection& d : gaussHemisphere(8, 16)) {  // exact: bands 4 and 5 have degree 9
        evalBasis(kFieldOrder, d.direction, y);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < kFarCoefficients; ++k)
                sum[i * kFarCoefficients + k] += d.weight * y[i] * y[std::size_t(even[k])];
    }
    return std::vector<float>(sum.begin(), sum.end());
}

// Adds what one half of the sphere has, from numbers that are mirrored at the horizon of (normal, tangent).
void addHalf(const std::vector<float>& matrix, int order, const float* mirrored, Vec3 normal, Vec3 tangent,
             std::span<float> out) {
    std::array<float, coefficientCount(kCastOrder)> local{}, turned{};
    const std::span<float> in = std::span(local).first(out.size()), in_scene = std::span(turned).first(out.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        for (std::size_t k = 0; k < kFarCoefficients; ++k) in[i] += matrix[i * kFarCoefficients + k] * mirrored[k];
    applyTransposed(makeShRotation(order, toLocalFrame(normal, tangent)), in, in_scene);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += in_scene[i];
}

void joinHalves(const CastShadow& cast, CasterChoice choice, int order, const CastReceivers& receivers, int threads,
                std::span<float> out) {
    const std::vector<float> matrix = momentMatrix(order);
    const std::size_t count = receivers.positions.size(), n = std::size_t(coefficientCount(order));
    std::vector<Vec3> normals(receivers.normals.begin(), receivers.normals.end());
    for (int half = 0; half < 2; ++half) {
        parallelFor((count + kFieldPiece - 1) / kFieldPiece, threads, [&](std::size_t piece) {
            const std::size_t first = piece * kFieldPiece, size = std::min(kFieldPiece, count - first);
            std::vector<float> mirrored(size * kFarCoefficients);
            cast.evaluate(
                {receivers.positions.subspan(first, size), std::span<const Vec3>(normals).subspan(first, size),
                 receivers.tangents.subspan(first, size)},
                choice, mirrored);
            for (std::size_t i = 0; i < size; ++i)
                addHalf(matrix, order, &mirrored[i * kFarCoefficients], normals[first + i],
                        receivers.tangents[first + i], out.subspan((first + i) * n, n));
        });
        for (Vec3& normal : normals) normal = normal * -1.0f;
    }
}

}  // namespace

void castOverSphere(const CastShadow& cast, CasterChoice choice, int order, const CastReceivers& receivers, int threads,
                    std::vector<float>& out) {
    const std::size_t count = receivers.positions.size(), n = std::size_t(coefficientCount(order));
    out.assign(count * n, 0.0f);
    if (cast.castsFields(choice)) return joinHalves(cast, choice, order, receivers, threads, out);
    const std::vector<CasterSphere> spheres = cast.spheresOf(choice);
    parallelFor((count + kReferencePiece - 1) / kReferencePiece, threads, [&](std::size_t piece) {
        std::array<double, coefficientCount(kCastOrder)> v;
        for (std::size_t r = piece * kReferencePiece; r < std::min(count, (piece + 1) * kReferencePiece); ++r) {
            castReference(cast.exponential(), order, spheres, receivers.positions[r], kSphereFade,
                          std::span(v).first(n));
            std::copy_n(v.begin(), n, out.begin() + std::ptrdiff_t(r * n));
        }
    });
}

}  // namespace penumbra
