#pragma once
// Functions that are mirrored at the horizon (convention D, sh/visibility_convention.h) and their products. Only
// coefficients with even l+m are stored, in the order of evenIndices(). What lies below the horizon never mixes in, and
// a product takes a fraction of the terms of one over the whole sphere (docs/formulas.md, section 7).
#include <cstdint>
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int mirroredCount(int order) { return order * (order + 1) / 2; }

// Mirrors what a function f has above the horizon: out_i = 2 integral over the upper hemisphere of f y_i.
// `coefficients` are those of f over the whole sphere, [order^2] in the local frame; out.size() ==
// mirroredCount(order). order <= kMaxOrder.
void mirrorAtHorizon(int order, std::span<const float> coefficients, std::span<float> out);

// Computes the product of two mirrored functions, exact for the bands that are given, up to `order_out`. `out` may not
// overlap a or b. Orders <= kMaxOrder.
void multiplyMirrored(int order_out, std::span<const float> a, int order_a, std::span<const float> b, int order_b,
                      std::span<float> out);

// The same for many products of the same orders: it finds its table once, which multiplyMirrored() looks up every time.
class MirroredProduct {
public:
    MirroredProduct(int order_out, int order_a, int order_b);
    void operator()(std::span<const float> a, std::span<const float> b, std::span<float> out) const;

private:
    struct Term {
        std::uint8_t j, k;
        float value;
    };
    std::vector<Term> terms_;
    std::vector<std::uint16_t> first_;  // of output i: terms first_[i] up to first_[i + 1]
};

}  // namespace penumbra
