#include "runtime/cast/cast_product.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "runtime/shade/shading.h"
#include "sh/far/far_tables.h"
#include "sh/sh_product.h"

namespace penumbra {

CastProduct::CastProduct(const Convention& convention)
    : convention_(convention),
      size_(std::size_t(convention.size())),
      weights_(size_),
      below_(size_),
      even_(evenIndices(kFieldOrder)) {
    ambientWeights(convention, weights_);
    for (const float w : weights_) norm2_ += w * w;
    if (convention.below == BelowHorizon::kOpen) belowHorizonCoefficients(convention.order, below_);
    // The tables of products are made once, now.
    if (convention.below == BelowHorizon::kMirrored) in_mirror_ = &productConstants(convention.order);
    std::vector<float> coefficients(size_), open(kFarCoefficients);
    (*this)(coefficients, size_, open);
}

void CastProduct::operator()(std::span<float> coefficients, std::size_t stride, std::span<const float> mirrored) const {
    const std::size_t vertices = coefficients.size() / stride;
    assert(stride >= size_ && mirrored.size() == vertices * kFarCoefficients);
    if (in_mirror_)
        fastestFarPath().compose(*in_mirror_, mirrored.data(), nullptr, vertices, stride, coefficients.data());
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::span<float> row = coefficients.subspan(v * stride, size_);
        if (!in_mirror_) multiplyAbove(row, mirrored.subspan(v * kFarCoefficients, kFarCoefficients));
        clampAmbient(weights_, norm2_, row);
    }
}

// What is 0 below the horizon stays 0 there, whatever it is multiplied by.
void CastProduct::multiplyAbove(std::span<float> coefficients, std::span<const float> mirrored) const {
    std::array<double, coefficientCount(kMaxOrder)> above, product;
    std::array<double, coefficientCount(kFieldOrder)> others{};
    for (std::size_t i = 0; i < kFarCoefficients; ++i) others[std::size_t(even_[i])] = mirrored[i];
    for (std::size_t i = 0; i < size_; ++i) above[i] = coefficients[i] - below_[i];
    const int order = convention_.order;
    penumbra::multiply(order, std::span(above).first(size_), order, others, kFieldOrder,
                       std::span(product).first(size_));
    for (std::size_t i = 0; i < size_; ++i) coefficients[i] = float(product[i] + below_[i]);
}

}  // namespace penumbra
