#include "formats/stage/transfer_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "formats/common/parallel_for.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr std::size_t kErrorBlock = 256;  // vertices of a task; fixed, so that the sums do not depend on threads

}  // namespace

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
