#pragma once

namespace penumbra {

// Square root for tables that the compiler makes, by Newton's method. value >= 0; the result is exact to an ulp or two.
constexpr double constexprSqrt(double value) {
    if (value == 0) return 0;
    double root = value > 1 ? value : 1;
    for (int i = 0; i < 64; ++i) root = (root + value / root) / 2;
    return root;
}

}  // namespace penumbra
