#pragma once
#include <span>
#include <vector>

#include "runtime/shade/shade_kernel.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Turns the visibility of a point, as coefficients in its local frame, into its transfer: the integrals over the
// hemisphere of V cos y_i, whose product with the SH of a light is the irradiance. The coefficients of A are those of a
// function that is open below the horizon, but only what is above counts.
class VisibilityTransfer {
public:
    static constexpr int kMaxTransferOrder = 5;
    explicit VisibilityTransfer(const Convention& convention);

    // Writes transfer [order^2], order 1..kMaxTransferOrder, in the frame that `to_local` (toLocalFrame()) leads from.
    // Allocates nothing.
    void apply(std::span<const float> coefficients, const Mat3& to_local, int order, std::span<float> transfer) const;

private:
    std::vector<SparseTerm> terms_;  // by `to`; `from` is a position among the coefficients
};

}  // namespace penumbra
