#pragma once
// Products of SH functions. Gamma_ijk is the integral of y_i y_j y_k (formulas: Nowrouzezahrai 2009 eq. 2; exact by
// Gauss quadrature).
#include <cstdint>
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

struct TripleProductEntry {
    std::uint16_t i, j, k;
    double value;
};

// Returns the entries of Gamma with |value| > 1e-12 for i < order_i^2, j < order_j^2 and k < order_k^2, sorted by (i,
// j, k). Any order up to kMaxProductOrder is possible. Results are cached: the reference stays valid, and calls from
// many threads are safe.
const std::vector<TripleProductEntry>& tripleProduct(int order_i, int order_j, int order_k);

// Returns M_ij = sum_k u_k Gamma_ijk, row-major [order^2, order^2]. u has order_u^2 coefficients. order_u = 2 order - 1
// gives the exact operator, the integral of U y_i y_j; order_u = order gives the papers' truncated one.
std::vector<double> productMatrix(int order, std::span<const double> u, int order_u);

// Computes (a x b)_i = sum_jk Gamma_ijk a_j b_k for i < order_out^2. After truncation the product is not associative,
// so fix the order of the factors.
void multiply(int order_out, std::span<const double> a, int order_a, std::span<const double> b, int order_b,
              std::span<double> out);

}  // namespace penumbra
