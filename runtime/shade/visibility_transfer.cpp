#include "runtime/shade/visibility_transfer.h"

#include <array>
#include <cmath>

#include "sh/cosine_product.h"
#include "sh/sh_rotation.h"

namespace penumbra {

VisibilityTransfer::VisibilityTransfer(const Convention& convention) {
    const std::vector<int> indices = convention.indices();
    const std::vector<double> cosine = cosineMatrix(kMaxTransferOrder, convention.order);
    const auto columns = std::size_t(coefficientCount(convention.order));
    for (std::size_t i = 0; i < std::size_t(coefficientCount(kMaxTransferOrder)); ++i)
        for (std::size_t j = 0; j < indices.size(); ++j) {
            const double value = cosine[i * columns + std::size_t(indices[j])];
            if (std::abs(value) > 1e-12) terms_.push_back({std::uint16_t(i), std::uint16_t(j), float(value)});
        }
}

void VisibilityTransfer::apply(std::span<const float> coefficients, const Mat3& to_local, int order,
                               std::span<float> transfer) const {
    std::array<float, coefficientCount(kMaxTransferOrder)> local{};
    for (const SparseTerm& term : terms_) {
        if (term.to >= transfer.size()) break;  // this band and all that follow were not asked for
        local[term.to] += term.value * coefficients[term.from];
    }
    applyTransposed(makeShRotation(order, to_local), std::span<const float>(local).first(transfer.size()), transfer);
}

}  // namespace penumbra
