#include "sh/sh_basis.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/fixed_basis.h"

namespace penumbra {

int bandOfIndex(int index) {
    int band = 0;
    while (coefficientCount(band + 1) <= index) ++band;
    return band;
}

namespace {

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
