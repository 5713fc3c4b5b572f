#include "sh/zonal.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

namespace penumbra {

void rotateZonal(std::span<const double> z, Vec3d axis, std::span<double> out) {
    const int order = int(z.size());
    assert(order >= 1 && order <= kMaxProductOrder && int(out.size()) == coefficientCount(order));
    evalBasisReference(order, axis, out);
    for (int l = 0; l < order; ++l) {
        const double scale = std::sqrt(4 * std::numbers::pi / (2 * l + 1)) * z[l];
        for (int m = -l; m <= l; ++m) out[shIndex(l, m)] *= scale;
    }
}

// z_l is 2pi sqrt((2l+1)/4pi) times the integral of t P_l(t) over (0,1). That integral is 1/3 for l = 1, 0 for other
// odd l and (-1)^(l/2-1) / ((l+2)(l-1)) l! / (2^l (l/2)!^2) for even l.
void clampedCosineZonal(std::span<double> z) {
    double central = 1;  // l! / (2^l (l/2)!^2) with its sign (-1)^(l/2)
    for (int l = 0; l < int(z.size()); ++l) {
        if (l > 0 && l % 2 == 0) central *= -double(l - 1) / l;
        const double integral = l == 1 ? 1.0 / 3 : l % 2 ? 0.0 : -central / ((l + 2) * (l - 1));
        z[l] = std::sqrt((2 * l + 1) * std::numbers::pi) * integral;
    }
}

// The integral of P_l over (-1, h) is (P_l+1(h) - P_l-1(h)) / (2l+1), or 1 + h for l = 0.
void belowPlaneZonal(double height, std::span<double> z) {
    double before = 1, p = height;  // P_l-1 and P_l, from l = 1
    for (int l = 0; l < int(z.size()); ++l) {
        double integral = 1 + height;
        if (l > 0) {
            const double next = ((2 * l + 1) * height * p - l * before) / (l + 1);
            integral = (next - before) / (2 * l + 1);
            before = p;
            p = next;
        }
        z[l] = std::sqrt((2 * l + 1) * std::numbers::pi) * integral;
    }
}

void capVisibilityZonal(double angle, std::span<double> z) { belowPlaneZonal(std::cos(angle), z); }

}  // namespace penumbra
