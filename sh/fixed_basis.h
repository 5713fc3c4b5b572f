#pragma once
// evalBasis() for an order that the compiler knows, to be inlined in kernels.
#include <numbers>

#include "sh/constexpr_sqrt.h"
#include "sh/sh_basis.h"

namespace penumbra {

// y(l,+-m) = Q_lm(z) {Re, Im} (x+iy)^m with the normalisation in Q:
//   Q_mm = (-1)^m sqrt(2 - delta_m0) sqrt((2m+1)!! / (2m)!! / 4pi),  Q_m+1,m = sqrt(2m+3) z Q_mm,
//   Q_lm = rise_lm z Q_l-1,m - fall_lm Q_l-2,m.
struct LegendreRecurrence {
    double start[kMaxOrder] = {};
    double rise[kMaxOrder][kMaxOrder] = {};
    double fall[kMaxOrder][kMaxOrder] = {};
};

constexpr LegendreRecurrence makeRecurrence() {
    LegendreRecurrence r;
    double product = 1 / (4 * std::numbers::pi);
    for (int m = 0; m < kMaxOrder; ++m) {
        if (m > 0) product *= double(2 * m + 1) / (2 * m);
        r.start[m] = (m % 2 ? -1 : 1) * constexprSqrt((m ? 2 : 1) * product);
        for (int l = m + 1; l < kMaxOrder; ++l) {
            const double squares = l * l - m * m;
            r.rise[l][m] = constexprSqrt((4.0 * l * l - 1) / squares);
            if (l > m + 1)
                r.fall[l][m] = constexprSqrt((2 * l + 1) * ((l - 1.0) * (l - 1) - m * m) / ((2 * l - 3) * squares));
        }
    }
    return r;
}
inline constexpr LegendreRecurrence kRecurrence = makeRecurrence();

// Writes y_i(d) to out[Order^2]. The order is a template parameter so that the loops unroll and the table becomes
// immediate constants.
template <int Order, class T>
inline void evalBasisFixed(BasicVec3<T> d, T* out) {
    T re = 1, im = 0;  // (x+iy)^m
    for (int m = 0; m < Order; ++m) {
        T before = 0, q = T(kRecurrence.start[m]);
        for (int l = m; l < Order; ++l) {
            if (l > m) {
                const T next = T(kRecurrence.rise[l][m]) * d.z * q - T(kRecurrence.fall[l][m]) * before;
                before = q;
                q = next;
            }
            out[shIndex(l, m)] = q * re;
            if (m > 0) out[shIndex(l, -m)] = q * im;
        }
        const T next_re = d.x * re - d.y * im;
        im = d.x * im + d.y * re;
        re = next_re;
    }
}

}  // namespace penumbra
