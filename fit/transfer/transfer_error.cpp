#include "fit/transfer/transfer_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "formats/common/parallel_for.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

constexpr std::size_t kErrorBlock = 256;  // vertices of a task; fixed, so that the sums do not depend on threads

// Returns a rotation that takes +z to the normal. Which one makes no difference, because H is symmetric about z.
Mat3d frameOf(Vec3d normal) {
    const Vec3d axis = std::abs(normal.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    const Vec3d t = normalized(cross(axis, normal)), b = cross(normal, t);
    return {{t.x, b.x, normal.x, t.y, b.y, normal.y, t.z, b.z, normal.z}};
}

}  // namespace

HemisphereNorm::HemisphereNorm(int order) : order_(order) {
    const int n = coefficientCount(order);
    std::vector<double> h(std::size_t(n * n)), y(static_cast<std::size_t>(n));
    for (const WeightedDirection& sample : gaussHemisphere(2 * order, 4 * order)) {
        evalBasis(order, sample.direction, std::span(y));
        for (int i = 0; i < n; ++i)
            for (int j = i; j < n; ++j)
                h[std::size_t(i * n + j)] += sample.weight * y[std::size_t(i)] * y[std::size_t(j)];
    }
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            const double value = h[std::size_t(i * n + j)];
            if (std::abs(value) > 1e-12) entries_.push_back({i, j, i == j ? value : 2 * value});
        }
}

double HemisphereNorm::ofLocal(std::span<const double> local) const {
    double sum = 0;
    for (const Entry& entry : entries_) sum += entry.value * local[std::size_t(entry.i)] * local[std::size_t(entry.j)];
    return sum;
}

std::array<double, 2> HemisphereNorm::squared(std::span<const double> a, std::span<const double> b, Vec3 normal) const {
    if (normal == Vec3{}) return {0, 0};
    const ShRotationD rotation = makeShRotation(order_, frameOf(normalized(toDouble(normal))));
    std::array<double, coefficientCount(kMaxOrder)> values;
    const std::span<double> local = std::span(values).first(a.size());
    applyTransposed(rotation, a, local);
    const double of_a = ofLocal(local);
    applyTransposed(rotation, b, local);
    return {of_a, ofLocal(local)};
}

void TransferSums::add(const TransferSums& other) {
    difference += other.difference;
    variance += other.variance;
    transfer_error += other.transfer_error;
    transfer_norm += other.transfer_norm;
    count += other.count;
}

TransferErrors errorsOf(const TransferSums& sums) {
    const auto ratio = [](double a, double b) { return b > 0 ? std::sqrt(std::max(a, 0.0) / b) : 0; };
    return {ratio(sums.difference, sums.variance),
            sums.count > 0 ? std::max(sums.transfer_error, 0.0) / double(sums.count) : 0,
            ratio(sums.transfer_error, sums.transfer_norm)};
}

TransferSums compareTransfer(const HemisphereNorm& norm, std::span<const float> predicted, std::span<const float> truth,
                             std::span<const float> mean, std::span<const Vec3> normals, int threads) {
    const std::size_t n = predicted.size() / normals.size(), blocks = (normals.size() + kErrorBlock - 1) / kErrorBlock;
    assert(predicted.size() == truth.size() && mean.size() == truth.size());
    std::vector<TransferSums> of_block(blocks);
    parallelFor(blocks, threads, [&](std::size_t block) {
        TransferSums& sums = of_block[block];
        std::array<double, coefficientCount(kMaxOrder)> difference, whole;
        for (std::size_t v = block * kErrorBlock; v < std::min((block + 1) * kErrorBlock, normals.size());
             ++v, ++sums.count) {
            for (std::size_t i = 0; i < n; ++i) {
                whole[i] = truth[v * n + i];
                difference[i] = predicted[v * n + i] - whole[i];
                sums.difference += difference[i] * difference[i];
                sums.variance += (whole[i] - mean[v * n + i]) * (whole[i] - mean[v * n + i]);
            }
            const auto [error, of_truth] =
                norm.squared(std::span(difference).first(n), std::span(whole).first(n), normals[v]);
            sums.transfer_error += error;
            sums.transfer_norm += of_truth;
        }
    });
    TransferSums sum;
    for (const TransferSums& sums : of_block) sum.add(sums);
    return sum;
}

}  // namespace penumbra
