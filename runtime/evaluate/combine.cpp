#include "runtime/evaluate/combine.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

std::size_t pairBytes(std::size_t components, std::size_t count) {
    return (count + kPairTile - 1) / kPairTile * kPairTile * ((components + 1) / 2 * 2);
}

void appendPairs(const std::int8_t* basis, std::size_t components, std::size_t count, std::vector<std::int8_t>& out) {
    const std::size_t first = out.size(), pairs = (components + 1) / 2;
    out.resize(first + pairBytes(components, count));
    for (std::size_t k = 0; k < components; ++k)
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t tile = i / kPairTile * pairs + k / 2;
            out[first + 2 * (tile * kPairTile + i % kPairTile) + k % 2] = basis[k * count + i];
        }
}

float packWeights(std::span<const float> weights, std::span<std::uint32_t> pairs) {
    assert(pairs.size() == (weights.size() + 1) / 2);
    float most = 0, sum = 0;
    for (float w : weights) {
        most = std::max(most, std::abs(w));
        sum += std::abs(w);
    }
    constexpr float kMaxSum = 16e6f;  // times 128 this is below 2^31
    // The unit is fine enough that the largest weight uses all 16 bits, unless the 32-bit sum could overflow then.
    const float unit = std::max(most / 32767, sum / kMaxSum);
    const auto rounded = [&](std::size_t k) {
        return k < weights.size() && unit > 0 ? std::uint32_t(std::lrint(weights[k] / unit)) & 0xffffu : 0u;
    };
    for (std::size_t p = 0; p < pairs.size(); ++p) pairs[p] = rounded(2 * p) | rounded(2 * p + 1) << 16;
    return unit;
}

}  // namespace penumbra
