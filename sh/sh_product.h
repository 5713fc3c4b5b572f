#pragma once
// Products of SH functions. Gamma_ijk = integral of y_i y_j y_k (formulas: paper 000 eq. 2; exact by Gauss quadrature).
#include <cstdint>
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

struct TripleProductEntry {
    std::uint16_t i, j, k;
    double value;
};

// The non-zero entries of Gamma for i < order_i^2, j < order_j^2, k < order_k^2, sorted by (i, j, k); |value| > 1e-12.
// Any order up to kMaxProductOrder. Cached: the reference stays valid; safe to call from many threads.
const std::vector<TripleProductEntry>& tripleProduct(int order_i, int order_j, int order_k);

// M_ij = sum_k u_k Gamma_ijk, row-major [order^2, order^2]. u has order_u^2 coefficients; order_u = 2 order - 1 gives
// the exact operator integral U y_i y_j, order_u = order the papers' truncated one.
std::vector<double> productMatrix(int order, std::span<const double> u, int order_u);

// (a x b)_i = sum_jk Gamma_ijk a_j b_k, for i < order_out^2. Not associative after truncation: fix the order of
// factors.
void multiply(int order_out, std::span<const double> a, int order_a, std::span<const double> b, int order_b,
              std::span<double> out);

}  // namespace penumbra
