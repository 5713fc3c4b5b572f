#include "sh/sh_product.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <tuple>
#include <utility>

#include "sh/mutex.h"
#include "sh/quadrature.h"

namespace penumbra {

namespace {

// y(l,m) = N_l|m|(z) trig_m(azimuth), where trig_m is cos(m phi) for m >= 0 and sin(|m| phi) for m < 0. So
//   Gamma_ijk = (integral of N N N over z) (integral of trig trig trig over the azimuth).
// The second factor is a closed form and mostly zero. Where it is not zero, |m1|+|m2|+|m3| is even. The first integrand
// is then a polynomial in z of degree l1+l2+l3 <= 42, for which Gauss-Legendre quadrature is exact.
constexpr int kNodes = 22;  // exact to degree 43

// Returns the integral of trig_a trig_b trig_c over [0, 2pi]: each of the four sums a+-b+-c that vanishes gives pi/2.
double azimuthIntegral(int a, int b, int c) {
    if (((a < 0) + (b < 0) + (c < 0)) % 2 != 0) return 0;
    if (a < 0) std::swap(a, b >= 0 ? b : c);  // put the cosine first; two cosines or two sines follow
    const bool sines = b < 0;
    double sum = 0;
    for (int sign_b : {1, -1})
        for (int sign_c : {1, -1})
            if (a + sign_b * std::abs(b) + sign_c * std::abs(c) == 0) sum += sines ? -sign_b * sign_c : 1;
    return sum * std::numbers::pi / 2;
}

struct LegendreTable {
    std::array<double, kNodes> weight;                                             // dz
    std::array<std::array<double, kNodes>, coefficientCount(kMaxProductOrder)> n;  // N_l|m| at shIndex(l, m >= 0)
};

LegendreTable makeLegendreTable() {
    LegendreTable table;
    std::array<double, coefficientCount(kMaxProductOrder)> y;
    const std::vector<WeightedDirection> nodes = gaussSphere(kNodes, 1);  // azimuth 0: trig_m = 1 for m >= 0
    for (int q = 0; q < kNodes; ++q) {
        table.weight[q] = nodes[q].weight / (2 * std::numbers::pi);
        evalBasisReference(kMaxProductOrder, nodes[q].direction, y);
        for (std::size_t i = 0; i < y.size(); ++i) table.n[i][q] = y[i];
    }
    return table;
}

std::vector<TripleProductEntry> computeTripleProduct(int order_i, int order_j, int order_k) {
    static const LegendreTable table = makeLegendreTable();
    std::vector<TripleProductEntry> entries;
    for (int i = 0; i < coefficientCount(order_i); ++i)
        for (int j = 0; j < coefficientCount(order_j); ++j) {
            const int li = bandOfIndex(i), mi = i - shIndex(li, 0), lj = bandOfIndex(j), mj = j - shIndex(lj, 0);
            std::array<double, kNodes> pair;
            const auto &ni = table.n[shIndex(li, std::abs(mi))], &nj = table.n[shIndex(lj, std::abs(mj))];
            for (int q = 0; q < kNodes; ++q) pair[q] = table.weight[q] * ni[q] * nj[q];
            // All other integrals over z vanish by the triangle rule and by the parity of the bands.
            for (int lk = std::abs(li - lj); lk <= std::min(li + lj, order_k - 1); lk += 2)
                for (int mk = -lk; mk <= lk; ++mk) {
                    const double azimuth = azimuthIntegral(mi, mj, mk);
                    if (azimuth == 0) continue;
                    const auto& nk = table.n[shIndex(lk, std::abs(mk))];
                    double sum = 0;
                    for (int q = 0; q < kNodes; ++q) sum += pair[q] * nk[q];
                    if (std::abs(sum * azimuth) > 1e-12)
                        entries.push_back(
                            {std::uint16_t(i), std::uint16_t(j), std::uint16_t(shIndex(lk, mk)), sum * azimuth});
                }
        }
    return entries;
}

}  // namespace

const std::vector<TripleProductEntry>& tripleProduct(int order_i, int order_j, int order_k) {
    assert(order_i >= 1 && order_i <= kMaxProductOrder && order_j >= 1 && order_j <= kMaxProductOrder && order_k >= 1 &&
           order_k <= kMaxProductOrder);
    static Mutex mutex;
    static std::map<std::tuple<int, int, int>, std::unique_ptr<std::vector<TripleProductEntry>>> cache;
    const std::lock_guard lock(mutex);
    auto& slot = cache[{order_i, order_j, order_k}];
    if (!slot)
        slot = std::make_unique<std::vector<TripleProductEntry>>(computeTripleProduct(order_i, order_j, order_k));
    return *slot;
}

std::vector<double> productMatrix(int order, std::span<const double> u, int order_u) {
    assert(int(u.size()) == coefficientCount(order_u));
    const int n = coefficientCount(order);
    std::vector<double> matrix(std::size_t(n) * n);
    for (const TripleProductEntry& e : tripleProduct(order, order, order_u)) matrix[e.i * n + e.j] += u[e.k] * e.value;
    return matrix;
}

void multiply(int order_out, std::span<const double> a, int order_a, std::span<const double> b, int order_b,
              std::span<double> out) {
    assert(int(a.size()) == coefficientCount(order_a) && int(b.size()) == coefficientCount(order_b) &&
           int(out.size()) == coefficientCount(order_out));
    std::fill(out.begin(), out.end(), 0.0);
    for (const TripleProductEntry& e : tripleProduct(order_out, order_a, order_b))
        out[e.i] += e.value * a[e.j] * b[e.k];
}

}  // namespace penumbra
