#include "pack/least_squares.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

double dotOf(const float* a, const float* b, std::size_t n) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) sum += double(a[i]) * b[i];
    return sum;
}

}  // namespace

// Gram-Schmidt on coefficients: q_k = (b_k - sum_j (q_j . b_k) q_j) / |.|, each q kept as its row over the b.
SpanProjector::SpanProjector(std::vector<float> basis, std::size_t length)
    : basis_(std::move(basis)), length_(length), factor_() {
    const std::size_t count = length > 0 ? basis_.size() / length : 0;
    std::vector<double> gram(count * count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j <= i; ++j)
            gram[i * count + j] = gram[j * count + i] =
                dotOf(basis_.data() + i * length, basis_.data() + j * length, length);
    factor_.assign(count * count, 0);
    for (std::size_t k = 0; k < count; ++k) {
        std::vector<double> row(count);
        row[k] = 1;
        double squared = gram[k * count + k];
        for (std::size_t j = 0; j < k; ++j) {
            double along = 0;
            for (std::size_t i = 0; i <= j; ++i) along += factor_[j * count + i] * gram[i * count + k];
            squared -= along * along;
            for (std::size_t i = 0; i <= j; ++i) row[i] -= along * factor_[j * count + i];
        }
        if (!(squared > 1e-9 * gram[k * count + k])) continue;
        for (std::size_t i = 0; i <= k; ++i) factor_[k * count + i] = row[i] / std::sqrt(squared);
    }
}

std::vector<double> SpanProjector::coordinates(std::span<const float> point, std::span<const float> origin,
                                               std::vector<float>& difference) const {
    difference.resize(length_);
    for (std::size_t i = 0; i < length_; ++i) difference[i] = point[i] - origin[i];
    const std::size_t count = length_ > 0 ? basis_.size() / length_ : 0;
    std::vector<double> along(count), result(count);
    for (std::size_t k = 0; k < count; ++k) along[k] = dotOf(basis_.data() + k * length_, difference.data(), length_);
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = 0; i <= k; ++i) result[k] += factor_[k * count + i] * along[i];
    return result;
}

double SpanProjector::squaredDistance(std::span<const float> point, std::span<const float> origin) const {
    std::vector<float> difference;
    const std::vector<double> components = coordinates(point, origin, difference);
    double squared = dotOf(difference.data(), difference.data(), length_);
    for (double component : components) squared -= component * component;
    return std::max(0.0, squared);
}

void SpanProjector::project(std::span<const float> point, std::span<const float> origin, std::span<float> out) const {
    std::vector<float> difference;
    const std::vector<double> components = coordinates(point, origin, difference);
    const std::size_t count = components.size();
    std::vector<double> sum(origin.begin(), origin.end());
    for (std::size_t i = 0; i < count; ++i) {
        double weight = 0;
        for (std::size_t k = i; k < count; ++k) weight += components[k] * factor_[k * count + i];
        for (std::size_t n = 0; n < length_; ++n) sum[n] += weight * basis_[i * length_ + n];
    }
    std::copy(sum.begin(), sum.end(), out.begin());
}

}  // namespace penumbra
