#include "player/runtime/cast_product.h"

#include <algorithm>
#include <array>

#include "player/runtime/shading.h"
#include "sh/far_visibility.h"
#include "sh/sh_product.h"

namespace penumbra {

CastProduct::CastProduct(const Convention& convention)
    : convention_(convention),
      in_mirror_(convention.order, convention.order, kFieldOrder),
      size_(std::size_t(convention.size())),
      weights_(size_),
      below_(size_),
      even_(evenIndices(kFieldOrder)) {
    ambientWeights(convention, weights_);
    for (const float w : weights_) norm2_ += w * w;
    if (convention.below == BelowHorizon::kOpen) belowHorizonCoefficients(convention.order, below_);
    // The tables of products are made once, now.
    std::vector<float> numbers(size_), open(std::size_t(mirroredCount(kFieldOrder)));
    (*this)(numbers, open);
}

void CastProduct::operator()(std::span<float> numbers, std::span<const float> mirrored) const {
    if (convention_.below == BelowHorizon::kMirrored)
        multiplyInMirror(numbers, mirrored);
    else
        multiplyAbove(numbers, mirrored);
    clampAmbient(weights_, norm2_, numbers);
}

void CastProduct::multiplyInMirror(std::span<float> numbers, std::span<const float> mirrored) const {
    std::array<float, mirroredCount(kMaxOrder)> product;
    const std::span<float> out(product.data(), size_);
    in_mirror_(numbers, mirrored, out);
    std::copy(out.begin(), out.end(), numbers.begin());
}

// What is 0 below the horizon stays 0 there, whatever it is multiplied by.
void CastProduct::multiplyAbove(std::span<float> numbers, std::span<const float> mirrored) const {
    std::array<double, coefficientCount(kMaxOrder)> above, product;
    std::array<double, coefficientCount(kFieldOrder)> others{};
    for (std::size_t i = 0; i < kFarNumbers; ++i) others[std::size_t(even_[i])] = mirrored[i];
    for (std::size_t i = 0; i < size_; ++i) above[i] = numbers[i] - below_[i];
    const int order = convention_.order;
    penumbra::multiply(order, std::span(above).first(size_), order, others, kFieldOrder,
                       std::span(product).first(size_));
    for (std::size_t i = 0; i < size_; ++i) numbers[i] = float(product[i] + below_[i]);
}

}  // namespace penumbra
