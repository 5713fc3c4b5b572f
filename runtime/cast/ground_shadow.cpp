// V is 1 on the wedge between the horizon z = 0 and the plane s.u = 0, where u is up in the local frame at the angle b
// to the normal. Let u have azimuth 0. About the edge of the wedge, the y axis, directions are
// s = (sin e cos w, cos e, sin e sin w), and the wedge is 0 < w < pi - b. Integrated over e,
//
//     p_lm(w) = 2 int_0^pi y_lm sin e de = sum_k a_lmk cos k w,  k <= l and k = l mod 2,
//
// since y_lm with even l+m and m >= 0 is even in z and has the parity of l. So the mirrored coefficients are
//
//     A_lm(b) = int_0^(pi-b) p_lm = a_lm0 (pi - b) + sum_k>0 (-1)^(k+1) a_lmk sin(k b) / k,
//
// and at the azimuth phi of u they are A_l|m| times cos m phi, or sin |m| phi for negative m.
#include "runtime/cast/ground_shadow.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/far/far_tables.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr std::size_t kHarmonics = kFieldOrder;  // k = 0 .. order - 1

// Of one mirrored number: m with its sign, and a_lm0, then (-1)^(k+1) a_lmk / k.
struct WedgeRow {
    int m = 0;
    std::array<float, kHarmonics> terms{};
};
using WedgeRows = std::array<WedgeRow, kFarCoefficients>;

// p_lm(w) for every mirrored number, of those with m < 0 that of -m.
std::array<double, kFarCoefficients> wedgeSlice(double w, std::span<const int> even) {
    constexpr int kNodes = 32;
    std::array<double, kFarCoefficients> sum{};
    std::array<double, coefficientCount(kFieldOrder)> y;
    for (const WeightedNumber& node : gaussInterval(kNodes)) {
        const double e = node.x * std::numbers::pi, sine = std::sin(e);
        evalBasis(kFieldOrder, Vec3d{sine * std::cos(w), std::cos(e), sine * std::sin(w)}, y);
        for (std::size_t i = 0; i < kFarCoefficients; ++i) {
            const int band = int(std::sqrt(double(even[i]))), m = even[i] - band * (band + 1);
            sum[i] += 2 * std::numbers::pi * node.weight * sine * y[std::size_t(shIndex(band, std::abs(m)))];
        }
    }
    return sum;
}

WedgeRows makeWedgeRows() {
    constexpr int kSlices = 4 * int(kHarmonics);  // exact for cos k w with k < kHarmonics
    const std::vector<int> even = evenIndices(kFieldOrder);
    WedgeRows rows;
    for (std::size_t i = 0; i < kFarCoefficients; ++i) {
        const int band = int(std::sqrt(double(even[i])));
        rows[i].m = even[i] - band * (band + 1);
    }
    for (int n = 0; n < kSlices; ++n) {
        // p is even in w, so that half of the circle tells it. The middles of equal pieces are exact.
        const double w = (n + 0.5) * std::numbers::pi / kSlices;
        const std::array<double, kFarCoefficients> p = wedgeSlice(w, even);
        for (std::size_t i = 0; i < kFarCoefficients; ++i)
            for (int k = 0; k < int(kHarmonics); ++k) {
                const double scale = k == 0 ? 1.0 : 2.0 * (k % 2 == 1 ? 1 : -1) / k;
                rows[i].terms[std::size_t(k)] += float(scale * p[i] * std::cos(k * w) / kSlices);
            }
    }
    return rows;
}

const WedgeRows& wedgeRows() {
    static const WedgeRows rows = makeWedgeRows();
    return rows;
}

}  // namespace

void groundVisibility(std::span<const Vec3> normals, std::span<const Vec3> tangents, std::span<float> mirrored) {
    assert(tangents.size() == normals.size() && mirrored.size() == normals.size() * kFarCoefficients);
    const WedgeRows& rows = wedgeRows();
    for (std::size_t v = 0; v < normals.size(); ++v) {
        const float c = std::clamp(normals[v].y, -1.0f, 1.0f), s = std::sqrt(1 - c * c);
        const float x = tangents[v].y, y = cross(normals[v], tangents[v]).y, across = std::sqrt(x * x + y * y);
        // cos and sin of m phi, and of k b: the first is pi - b, which goes with k = 0.
        std::array<float, kHarmonics> cosines{1}, sines{}, harmonics{std::acos(-c)};
        if (across > 1e-12f) cosines[1] = x / across, sines[1] = y / across;
        harmonics[1] = s;
        for (std::size_t k = 2; k < kHarmonics; ++k) {
            cosines[k] = cosines[k - 1] * cosines[1] - sines[k - 1] * sines[1];
            sines[k] = sines[k - 1] * cosines[1] + cosines[k - 1] * sines[1];
            harmonics[k] = 2 * c * harmonics[k - 1] - (k == 2 ? 0 : harmonics[k - 2]);
        }
        float* const out = &mirrored[v * kFarCoefficients];
        for (std::size_t i = 0; i < kFarCoefficients; ++i) {
            float sum = 0;
            for (std::size_t k = 0; k < kHarmonics; ++k) sum += rows[i].terms[k] * harmonics[k];
            const auto m = std::size_t(std::abs(rows[i].m));
            out[i] = sum * (rows[i].m < 0 ? sines[m] : cosines[m]);
        }
    }
}

}  // namespace penumbra
