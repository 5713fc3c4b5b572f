#include "sh/cast/cast_fold.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "sh/sh_product.h"

namespace penumbra {

CastFold makeCastFold(int light_order, std::span<const float> light, int cast_order) {
    const std::size_t row = std::size_t(coefficientCount(light_order)) * 3;
    assert(light.size() == row);
    std::vector<double> matrix(std::size_t(coefficientCount(cast_order)) * row);
    for (const TripleProductEntry& e : tripleProduct(light_order, light_order, cast_order))
        for (std::size_t c = 0; c < 3; ++c) matrix[e.k * row + e.i * 3 + c] += e.value * light[e.j * 3u + c];
    return {light_order, cast_order, std::vector<float>(matrix.begin(), matrix.end())};
}

void foldCast(const CastFold& fold, std::span<const float> cast, std::span<float> out) {
    assert(int(cast.size()) == coefficientCount(fold.cast_order) &&
           int(out.size()) == coefficientCount(fold.light_order) * 3);
    std::fill(out.begin(), out.end(), 0.0f);
    for (std::size_t k = 0; k < cast.size(); ++k) {
        const float* row = fold.matrix.data() + k * out.size();
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += cast[k] * row[i];
    }
}

}  // namespace penumbra
