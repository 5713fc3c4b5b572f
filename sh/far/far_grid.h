#pragma once
// Products of mirrored functions, 8 at a time. Part of far_lanes.cpp.
#include "sh/far/far_turns.h"

namespace penumbra {

namespace {

inline void product(const FarProduct& table, const Lanes* a, const Lanes* b, Lanes* out) {
    Lanes pair[kMaxPairs];
    for (std::size_t n = 0; n < table.pairs; ++n) {
        const int j = table.j[n], k = table.k[n];
        pair[n] = a[j] * b[k];
        if (j != k) pair[n] += a[k] * b[j];
    }
    for (int i = 0; i < table.size_out; ++i) {
        Lanes sum = kZeros;
        for (const FarTerm* term = table.rows.terms + table.rows.first[i];
             term < table.rows.terms + table.rows.first[i + 1]; ++term)
            sum += term->value * pair[term->from];
        out[i] = sum;
    }
}

constexpr int kRings = 4, kAround = 16, kDirections = kRings * kAround;
// cos(pi n / 8) and sin(pi n / 8).
constexpr float kCos1 = 0.92387953f, kCos2 = 0.70710678f, kCos3 = 0.38268343f;

// Sums ring times f over the bands of order m.
template <int kN, int M>
inline void sumBands(const float* ring, const Lanes* f, Lanes& out) {
    constexpr int kFirst = M < 0 ? -M : M;
    if constexpr (kFirst >= kN) {
        out = kZeros;
    } else {
        out = ring[evenPlace(kFirst, M)] * f[evenPlace(kFirst, M)];
        if constexpr (kFirst + 2 < kN) out += ring[evenPlace(kFirst + 2, M)] * f[evenPlace(kFirst + 2, M)];
        if constexpr (kFirst + 4 < kN) out += ring[evenPlace(kFirst + 4, M)] * f[evenPlace(kFirst + 4, M)];
    }
}
template <int kN, int... M>
inline void sumOrders(const float* ring, const Lanes* f, Lanes* c, Lanes* s, Numbers<M...>) {
    (sumBands<kN, M>(ring, f, c[M]), ...);
    (sumBands<kN, -M>(ring, f, s[M]), ...);
}
// Adds ring times x to the bands of order m of f, or begins them.
template <int kN, int M>
inline void addToBands(const float* ring, const Lanes& x, bool begins, Lanes* f) {
    constexpr int kFirst = M < 0 ? -M : M;
    const auto add = [&](int l) __attribute__((always_inline)) {
        const int i = evenPlace(l, M);
        f[i] = begins ? ring[i] * x : f[i] + ring[i] * x;
    };
    if constexpr (kFirst < kN) add(kFirst);
    if constexpr (kFirst + 2 < kN) add(kFirst + 2);
    if constexpr (kFirst + 4 < kN) add(kFirst + 4);
}

template <int kN, int... M>
inline void addOrders(const float* ring, const Lanes* c, const Lanes* s, bool begins, Lanes* f, Numbers<0, M...>) {
    addToBands<kN, 0>(ring, c[0], begins, f);
    (addToBands<kN, M>(ring, c[M], begins, f), ...);
    (addToBands<kN, -M>(ring, s[M], begins, f), ...);
}

// Writes the values of f [count of order kN] at the directions. Around a ring f is sum of c_m cos(m phi) + s_m sin(m
// phi), phi = pi q / 8. Even and odd m repeat or turn over after half a round, so that half of each is computed.
template <int kN>
inline void toGrid(const FarGrid& grid, const Lanes* f, Lanes* values) {
    for (int k = 0; k < kRings; ++k, values += kAround) {
        const float* ring = grid.ring[k];
        Lanes c[kOrder], s[kOrder];
        sumOrders<kN>(ring, f, c, s, Upto<kOrder>());
        // 1. Even m: 4 values that repeat, and 4 that turn over.
        const Lanes same[4] = {c[0] + c[4], c[0] + s[4], c[0] - c[4], c[0] - s[4]};
        const Lanes over[4] = {c[2], kCos2 * (c[2] + s[2]), s[2], kCos2 * (s[2] - c[2])};
        Lanes even[8], odd[8];
        for (int q = 0; q < 4; ++q) {
            even[q] = same[q] + over[q];
            even[q + 4] = same[q] - over[q];
        }
        // 2. Odd m: cosines are odd about a quarter of a round, sines are even.
        const Lanes cosine[4] = {c[1] + c[3] + c[5], kCos1 * c[1] + kCos3 * c[3] - kCos3 * c[5],
                                 kCos2 * (c[1] - c[3] - c[5]), kCos3 * c[1] - kCos1 * c[3] + kCos1 * c[5]};
        const Lanes sine[5] = {kZeros, kCos3 * s[1] + kCos1 * s[3] + kCos1 * s[5], kCos2 * (s[1] + s[3] - s[5]),
                               kCos1 * s[1] - kCos3 * s[3] - kCos3 * s[5], s[1] - s[3] + s[5]};
        odd[0] = cosine[0];
        odd[4] = sine[4];
        for (int q = 1; q < 4; ++q) {
            odd[q] = sine[q] + cosine[q];
            odd[8 - q] = sine[q] - cosine[q];
        }
        for (int q = 0; q < 8; ++q) {
            values[q] = even[q] + odd[q];
            values[q + 8] = even[q] - odd[q];
        }
    }
}

// The transpose of toGrid(), with the weights of the directions: f_i = integral of the values times y_i.
template <int kN>
inline void fromGrid(const FarGrid& grid, const Lanes* values, Lanes* f) {
    for (int k = 0; k < kRings; ++k, values += kAround) {
        const float* ring = grid.ring_back[k];
        Lanes even[8], odd[8], same[4], over[4], c[kOrder], s[kOrder];
        for (int q = 0; q < 8; ++q) {
            even[q] = values[q] + values[q + 8];
            odd[q] = values[q] - values[q + 8];
        }
        for (int q = 0; q < 4; ++q) {
            same[q] = even[q] + even[q + 4];
            over[q] = even[q] - even[q + 4];
        }
        c[0] = (same[0] + same[2]) + (same[1] + same[3]);
        c[4] = same[0] - same[2];
        s[4] = same[1] - same[3];
        c[2] = over[0] + kCos2 * (over[1] - over[3]);
        s[2] = over[2] + kCos2 * (over[1] + over[3]);
        Lanes cosine[4], sine[4];
        for (int q = 1; q < 4; ++q) {
            cosine[q] = odd[q] - odd[8 - q];
            sine[q] = odd[q] + odd[8 - q];
        }
        const Lanes c2 = kCos2 * cosine[2], s2 = kCos2 * sine[2];
        c[1] = odd[0] + kCos1 * cosine[1] + c2 + kCos3 * cosine[3];
        c[3] = odd[0] + kCos3 * cosine[1] - c2 - kCos1 * cosine[3];
        c[5] = odd[0] - kCos3 * cosine[1] - c2 + kCos1 * cosine[3];
        s[1] = odd[4] + kCos3 * sine[1] + s2 + kCos1 * sine[3];
        s[3] = kCos1 * sine[1] + s2 - kCos3 * sine[3] - odd[4];
        s[5] = kCos1 * sine[1] - s2 - kCos3 * sine[3] + odd[4];
        const bool begins = k == 0;
        addOrders<kN>(ring, c, s, begins, f, Upto<kOrder>());
    }
}

// Multiplies on the grid, which is exact up to order 6.
template <int kN>
inline void multiplyOnGrid(const FarConstants& constants, const Lanes* a, const Lanes* b, Lanes* out) {
    Lanes local[kDirections], far[kDirections];
    toGrid<kN>(constants.grid, a, local);
    toGrid<kOrder>(constants.grid, b, far);
    for (int d = 0; d < kDirections; ++d) far[d] *= local[d];
    fromGrid<kN>(constants.grid, far, out);
}

}  // namespace

}  // namespace penumbra
