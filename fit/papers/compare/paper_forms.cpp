#include "fit/papers/compare/paper_forms.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

const NumberForm kUnclampedForm{kVisibilityForm.convert, kVisibilityForm.ambient_weights, 0, false};

const NumberForm kCosineForm{[](const Convention& convention, std::span<const float> local, const ShRotation&,
                                std::span<float> coefficients) { timesZ(convention.order, local, coefficients); },
                             // The first number is E pi / sqrt(4 pi).
                             [](const Convention& convention) {
                                 std::vector<float> weights(std::size_t(convention.size()));
                                 weights[0] = float(2 * std::numbers::inv_sqrtpi);
                                 return weights;
                             },
                             1, false};

const NumberForm kModelFrameForm{[](const Convention& convention, std::span<const float> local,
                                    const ShRotation& to_model, std::span<float> coefficients) {
                                     std::array<float, coefficientCount(kMaxOrder)> buffer;
                                     const std::span<float> visibility = std::span(buffer).first(coefficients.size());
                                     fromMoments(convention, local, visibility);
                                     apply(to_model, visibility, coefficients);
                                 },
                                 [](const Convention&) { return std::vector<float>(); }, 0, false};

void timesZ(int order, std::span<const float> moments, std::span<float> out) {
    assert(int(moments.size()) == coefficientCount(order + 1) && int(out.size()) == coefficientCount(order));
    const auto a = [](int l, int m) { return std::sqrt(double(l * l - m * m) / (4.0 * l * l - 1)); };
    for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m) {
            const double below = std::abs(m) < l ? a(l, m) * double(moments[std::size_t(shIndex(l - 1, m))]) : 0;
            out[std::size_t(shIndex(l, m))] =
                float(below + a(l + 1, m) * double(moments[std::size_t(shIndex(l + 1, m))]));
        }
}

}  // namespace penumbra
