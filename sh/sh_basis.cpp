#include "sh/sh_basis.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/constexpr_sqrt.h"

namespace penumbra {

int bandOfIndex(int index) {
    int band = 0;
    while (coefficientCount(band + 1) <= index) ++band;
    return band;
}

namespace {

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
constexpr LegendreRecurrence kRecurrence = makeRecurrence();

// The order is a template parameter so that the loops unroll and the table becomes immediate constants.
template <int Order, class T>
void evalBasisFixed(BasicVec3<T> d, T* out) {
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

template <class T>
void evalBasisAny(int order, BasicVec3<T> d, std::span<T> out) {
    assert(order >= 1 && order <= kMaxOrder && int(out.size()) == coefficientCount(order));
    switch (order) {
        case 1:
            return evalBasisFixed<1>(d, out.data());
        case 2:
            return evalBasisFixed<2>(d, out.data());
        case 3:
            return evalBasisFixed<3>(d, out.data());
        case 4:
            return evalBasisFixed<4>(d, out.data());
        case 5:
            return evalBasisFixed<5>(d, out.data());
        case 6:
            return evalBasisFixed<6>(d, out.data());
        case 7:
            return evalBasisFixed<7>(d, out.data());
        default:
            return evalBasisFixed<8>(d, out.data());
    }
}

}  // namespace

void evalBasis(int order, Vec3 direction, std::span<float> out) { evalBasisAny(order, direction, out); }
void evalBasis(int order, Vec3d direction, std::span<double> out) { evalBasisAny(order, direction, out); }

namespace {

// Writes P_lm(z) with the sign (-1)^m for l = m .. order-1 into p[l]; `sine` is sqrt(1 - z^2).
void associatedLegendre(int order, int m, double z, double sine, std::array<double, kMaxProductOrder>& p) {
    p[m] = 1;
    for (int k = 1; k <= m; ++k) p[m] *= -(2 * k - 1) * sine;
    if (m + 1 < order) p[m + 1] = (2 * m + 1) * z * p[m];
    for (int l = m + 2; l < order; ++l) p[l] = ((2 * l - 1) * z * p[l - 1] - (l + m - 1) * p[l - 2]) / (l - m);
}

// Returns sqrt((2l+1)/4pi (l-m)!/(l+m)!), times sqrt 2 for m > 0.
double normalisation(int l, int m) {
    double ratio = (2 * l + 1) / (4 * std::numbers::pi);
    for (int k = l - m + 1; k <= l + m; ++k) ratio /= k;
    return std::sqrt(m > 0 ? 2 * ratio : ratio);
}

}  // namespace

void evalBasisReference(int order, Vec3d direction, std::span<double> out) {
    assert(order >= 1 && order <= kMaxProductOrder && int(out.size()) == coefficientCount(order));
    const double azimuth = std::atan2(direction.y, direction.x), sine = std::hypot(direction.x, direction.y);
    std::array<double, kMaxProductOrder> p{};
    for (int m = 0; m < order; ++m) {
        associatedLegendre(order, m, direction.z, sine, p);
        for (int l = m; l < order; ++l) {
            const double value = normalisation(l, m) * p[l];
            out[shIndex(l, m)] = value * std::cos(m * azimuth);
            if (m > 0) out[shIndex(l, -m)] = value * std::sin(m * azimuth);
        }
    }
}

}  // namespace penumbra
