// Evaluates linear maps from the angles to the transfer of all vertices (docs/formulas.md, section 14).
//
// Naive: evaluate the n maps of a pose, which gives n numbers a vertex, and multiply these by the light.
//
// Here: shading is linear in the transfer and in the light, so the maps are summed over the light first. That leaves
// one map a colour channel, a third of a twelfth of the work at order 6, and a light that does not change costs
// nothing.
#include "runtime/papers/transfer_evaluator.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

constexpr std::size_t kTransferTile = 64;  // vertices of a tile, whose transfer stays in the first cache

// Returns the numbers where they lie if they are f32, else decoded.
std::span<const float> floatsOf(const NumbersView& coefficients, std::vector<float>& decoded) {
    if (coefficients.precision == AssetPrecision::kF32)
        return {reinterpret_cast<const float*>(coefficients.data), coefficients.count};
    decoded.resize(coefficients.count);
    decode(coefficients, decoded);
    return decoded;
}

}  // namespace

TransferEvaluator::TransferEvaluator(const AssetView& asset) : path_(transferPaths().back()) {
    const auto decoded = std::make_shared<Decoded>();
    decoded->view = *asset.transfer;
    decoded->vertices = asset.mesh.positions.size();
    weights_ = floatsOf(decoded->view.weights, decoded->weights);
    basis_ = floatsOf(decoded->view.basis, decoded->basis);
    const TransferView& view = decoded->view;
    inputs_.assign(view.inputs() + 1, 0);
    inputs_.back() = 1;
    if (view.reduced()) scores_.resize((view.coefficients() + 3) / 4 * 4 * view.outputs());
    decoded_ = decoded;
}

void TransferEvaluator::setPose(std::span<const float> pose) {
    const TransferView& view = decoded_->view;
    const std::size_t k = view.inputs(), m = view.outputs();
    // 1. The angles that the model sees, or their principal components.
    std::fill(inputs_.begin(), inputs_.end() - 1, 0.0f);
    for (std::size_t a = 0; a < view.angles.size(); ++a) {
        const float angle = pose[view.angles[a]];
        if (view.pose_basis.empty())
            inputs_[a] = angle;
        else
            for (std::size_t i = 0; i < k; ++i) inputs_[i] += angle * view.pose_basis[a * k + i];
    }
    if (!view.reduced()) return;
    // 2. The scores of every coefficient.
    for (std::size_t c = 0; c < view.coefficients(); ++c) {
        float* out = scores_.data() + c / 4 * 4 * m + c % 4;
        const float* map = weights_.data() + c * (k + 1) * m;
        for (std::size_t j = 0; j < m; ++j) {
            float sum = 0;
            for (std::size_t i = 0; i <= k; ++i) sum += inputs_[i] * map[i * m + j];
            out[4 * j] = sum;
        }
    }
    scoreLight();
}

void TransferEvaluator::setLight(std::span<const Vec3> sh) {
    if (std::ranges::equal(light_, sh)) return;
    const TransferView& view = decoded_->view;
    const std::size_t size = (view.inputs() + 1) * view.outputs();
    light_.assign(sh.begin(), sh.end());
    lit_scores_.resize(view.reduced() ? 3 * view.outputs() : 0);
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<float>& sum = lit_[std::size_t(channel)];
        sum.assign(size, 0);
        float& mean = lit_mean_[std::size_t(channel)];
        mean = 0;
        for (std::size_t c = 0; c < std::min(view.coefficients(), sh.size()); ++c) {
            const float factor = sh[c][channel];
            mean += factor;
            path_.add({weights_.data() + c * size, size, 1, &factor, 1, size, sum.data(), size});
        }
    }
    scoreLight();
}

void TransferEvaluator::scoreLight() {
    if (lit_scores_.empty()) return;
    const std::size_t k = inputs_.size(), m = decoded_->view.outputs();
    for (std::size_t channel = 0; channel < 3; ++channel)
        for (std::size_t j = 0; j < m; ++j) {
            float sum = 0;
            for (std::size_t i = 0; i < k; ++i) sum += inputs_[i] * lit_[channel][i * m + j];
            lit_scores_[3 * j + channel] = sum;
        }
}

void TransferEvaluator::irradiance(std::size_t begin, std::size_t end, std::span<Vec3> out) const {
    const TransferView& view = decoded_->view;
    const std::size_t vertices = decoded_->vertices;
    assert(begin <= end && end <= vertices && out.size() == end - begin && !light_.empty());
    std::array<float, 3 * kTransferTile> sums;
    for (std::size_t first = begin; first < end; first += kTransferTile) {
        const std::size_t width = std::min(kTransferTile, end - first);
        sums.fill(0);
        if (view.reduced()) {
            for (std::size_t channel = 0; channel < 3; ++channel)
                for (std::size_t v = 0; v < width; ++v)
                    sums[channel * kTransferTile + v] = lit_mean_[channel] * view.mean[first + v];
            path_.add({basis_.data() + first, vertices, view.outputs(), lit_scores_.data(), 3, width, sums.data(),
                       kTransferTile});
        } else {
            for (std::size_t channel = 0; channel < 3; ++channel)
                path_.add({lit_[channel].data() + first, vertices, inputs_.size(), inputs_.data(), 1, width,
                           sums.data() + channel * kTransferTile, kTransferTile});
        }
        for (std::size_t v = 0; v < width; ++v)
            out[first - begin + v] = {sums[v], sums[kTransferTile + v], sums[2 * kTransferTile + v]};
    }
}

void TransferEvaluator::transfer(std::size_t begin, std::size_t end, std::size_t stride,
                                 std::span<float> coefficients) const {
    const TransferView& view = decoded_->view;
    const std::size_t vertices = decoded_->vertices, n = view.coefficients(), m = view.outputs();
    assert(begin <= end && end <= vertices && coefficients.size() == vertices * stride && stride >= n);
    std::array<float, coefficientCount(kMaxOrder) * kTransferTile> sums;
    for (std::size_t first = begin; first < end; first += kTransferTile) {
        const std::size_t width = std::min(kTransferTile, end - first);
        if (view.reduced()) {
            for (std::size_t c = 0; c < (n + 3) / 4 * 4; ++c)
                std::copy_n(view.mean.begin() + std::ptrdiff_t(first), width,
                            sums.begin() + std::ptrdiff_t(c * kTransferTile));
            for (std::size_t c = 0; c < n; c += 4)
                path_.add({basis_.data() + first, vertices, m, scores_.data() + c * m, 4, width,
                           sums.data() + c * kTransferTile, kTransferTile});
        } else {
            sums.fill(0);
            for (std::size_t c = 0; c < n; ++c)
                path_.add({weights_.data() + c * inputs_.size() * m + first, vertices, inputs_.size(), inputs_.data(),
                           1, width, sums.data() + c * kTransferTile, kTransferTile});
        }
        for (std::size_t v = 0; v < width; ++v) {
            float* row = coefficients.data() + (first + v) * stride;
            for (std::size_t c = 0; c < n; ++c) row[c] = sums[c * kTransferTile + v];
            std::fill(row + n, row + stride, 0.0f);
        }
    }
}

void transferAmbient(int stride, std::span<const float> transfer, std::span<float> e) {
    assert(transfer.size() == e.size() * std::size_t(stride));
    for (std::size_t v = 0; v < e.size(); ++v)
        e[v] = float(2 / std::sqrt(std::numbers::pi)) * transfer[v * std::size_t(stride)];
}

}  // namespace penumbra
