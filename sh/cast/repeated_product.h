#pragma once
// Products of two SH functions of one order, many times over. multiply() (sh/sh_product.h) is the plain form.
//
// Gamma_ijk is symmetric in j and k. So the pairs a_j b_k + a_k b_j come first, once for all i, in an order in which
// they take no index table. Every output is then a short sum over pairs: half the terms of Gamma.
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

constexpr int kMaxRepeatedOrder = 6;
constexpr int kMaxProductPairs = coefficientCount(kMaxRepeatedOrder) * (coefficientCount(kMaxRepeatedOrder) + 1) / 2;

template <class T>
struct BasicRepeatedProduct {
    struct Term {
        std::uint16_t pair;  // place of (j, k), j <= k: all pairs of j = 0, then those of j = 1, ...
        T value;             // Gamma_ijk
    };
    int order = 0;
    std::vector<Term> terms;
    std::array<std::uint16_t, coefficientCount(kMaxRepeatedOrder) + 1> first{};  // [order^2 + 1] of output i
};

// Made once for each order up to kMaxRepeatedOrder, and kept.
template <class T>
const BasicRepeatedProduct<T>& repeatedProduct(int order);

template <class T>
inline void sumPairs(const BasicRepeatedProduct<T>& product, const T* pairs, T* out) {
    const int n = coefficientCount(product.order);
    const auto* term = product.terms.data();
    for (int i = 0; i < n; ++i) {
        T sum = 0;
        for (const auto* end = product.terms.data() + product.first[std::size_t(i) + 1]; term != end; ++term)
            sum += term->value * pairs[term->pair];
        out[i] = sum;
    }
}

// Computes out = a b, up to the order of both; [order^2] each. `out` may be a or b.
template <class T>
inline void multiply(const BasicRepeatedProduct<T>& product, const T* a, const T* b, T* out) {
    const int n = coefficientCount(product.order);
    T pairs[kMaxProductPairs];
    T* next = pairs;
    for (int j = 0; j < n; ++j) {
        *next++ = a[j] * b[j];
        for (int k = j + 1; k < n; ++k) *next++ = a[j] * b[k] + a[k] * b[j];
    }
    sumPairs(product, pairs, out);
}

// Computes out = a a. `out` may be a.
template <class T>
inline void square(const BasicRepeatedProduct<T>& product, const T* a, T* out) {
    const int n = coefficientCount(product.order);
    T pairs[kMaxProductPairs];
    T* next = pairs;
    for (int j = 0; j < n; ++j) {
        const T twice = 2 * a[j];
        *next++ = a[j] * a[j];
        for (int k = j + 1; k < n; ++k) *next++ = twice * a[k];
    }
    sumPairs(product, pairs, out);
}

}  // namespace penumbra
