#include "sh/cast/log_visibility.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <mutex>
#include <numbers>

#include "sh/sh_product.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

constexpr double kRootOfFourPi = 3.5449077018110318;  // the coefficient of the function 1
constexpr int kMaxSquarings = 8;
constexpr double kLinearNorm = 0.25;  // HYB-OL squares what is linear up to here
constexpr int kCurveCaps = 400;
constexpr double kMinCurveAngle = 1e-3, kMaxCurveAngle = 1.5;

// One cap has the visibility g = e^(f_0 / sqrt 4pi) g^ and the logarithm f. a is what of g^ is constant, and b is its
// projection on f^. m = |f^| mostly grows with the cap, and caps where it does not are left out.
LinearCurves makeLinearCurves(int order) {
    LinearCurves curves{{0}, {1}, {1}};
    std::vector<double> f(std::size_t(order), 0.0), g(f);
    for (int c = 0; c < kCurveCaps; ++c) {
        const double angle = kMinCurveAngle + (kMaxCurveAngle - kMinCurveAngle) * c / (kCurveCaps - 1);
        capLogZonal(angle, f);
        capVisibilityZonal(angle, g);
        const double constant = std::exp(f[0] / kRootOfFourPi);
        double along = 0, norm2 = 0;
        for (std::size_t l = 1; l < f.size(); ++l) {
            along += g[l] / constant * f[l];
            norm2 += f[l] * f[l];
        }
        if (std::sqrt(norm2) <= curves.norm.back()) continue;
        curves.norm.push_back(std::sqrt(norm2));
        curves.a.push_back(g[0] / constant / kRootOfFourPi);
        curves.b.push_back(along / norm2);
    }
    return curves;
}

struct LinearForm {
    double a, b;
};

LinearForm lookUp(const LinearCurves& curves, double norm) {
    const auto above = std::upper_bound(curves.norm.begin(), curves.norm.end(), norm);
    if (above == curves.norm.end()) return {curves.a.back(), curves.b.back()};
    const std::size_t k = std::size_t(above - curves.norm.begin());  // >= 1, as norm >= 0 = curves.norm[0]
    const double part = (norm - curves.norm[k - 1]) / (curves.norm[k] - curves.norm[k - 1]);
    return {curves.a[k - 1] + part * (curves.a[k] - curves.a[k - 1]),
            curves.b[k - 1] + part * (curves.b[k] - curves.b[k - 1])};
}

template <class T>
const BasicExpTables<T>& cachedExpTables(int order) {
    assert(order >= kMinLogOrder && order <= kMaxLogOrder);
    static std::array<std::once_flag, kMaxLogOrder + 1> made;
    static std::array<BasicExpTables<T>, kMaxLogOrder + 1> tables;
    const std::size_t n = std::size_t(order);
    std::call_once(made[n], [&] { tables[n] = {order, &repeatedProduct<T>(order), makeLinearCurves(order)}; });
    return tables[n];
}

// max(0, ceil(log2 x)).
int ceilLog2(double x) {
    int exponent;
    const double fraction = std::frexp(x, &exponent);  // x = fraction 2^exponent, fraction in [1/2, 1)
    return std::max(0, fraction == 0.5 ? exponent - 1 : exponent);
}

template <class T>
using Coefficients = std::array<T, coefficientCount(kMaxLogOrder)>;

// g = 1 + x + x x / 2 + ... up to the power `last`. x_0 is 0.
template <class T>
void powerSeries(const BasicRepeatedProduct<T>& product, const Coefficients<T>& x, int last, Coefficients<T>& g) {
    const std::size_t n = std::size_t(coefficientCount(product.order));
    g = {};
    if (last >= 1) g = x;
    g[0] += T(kRootOfFourPi);
    Coefficients<T> power = x;
    for (int k = 2; k <= last; ++k) {
        if (k == 2)
            square(product, power.data(), power.data());
        else
            multiply(product, power.data(), x.data(), power.data());
        for (std::size_t i = 0; i < n; ++i) {
            power[i] *= T(1) / T(k);
            g[i] += power[i];
        }
    }
}

template <class T>
void expAny(const BasicExpTables<T>& tables, const ExpOptions& options, std::span<const T> log, std::span<T> out) {
    const std::size_t n = std::size_t(coefficientCount(tables.order));
    assert(log.size() == n && out.size() == n);
    // 1. Scale the logarithm down by 2^p.
    T norm2 = 0;
    for (std::size_t i = 1; i < n; ++i) norm2 += log[i] * log[i];
    const T norm = std::sqrt(norm2);
    const int squarings = squaringCount(options, double(norm));
    const T scale = std::ldexp(T(1), -squarings);
    Coefficients<T> x{}, g{};
    for (std::size_t i = 1; i < n; ++i) x[i] = scale * log[i];
    // 2. Take the exponential of that.
    if (options.method == ExpMethod::kHybPs2) {
        powerSeries(*tables.product, x, options.smooth ? 3 : 2, g);
    } else if (options.method == ExpMethod::kPs) {
        powerSeries(*tables.product, x, options.terms, g);
    } else {
        const LinearForm form = lookUp(tables.curves, double(scale * norm));
        for (std::size_t i = 1; i < n; ++i) g[i] = T(form.b) * x[i];
        g[0] = T(form.a * kRootOfFourPi);
    }
    const T constant = std::exp(scale * log[0] / T(kRootOfFourPi));
    for (std::size_t i = 0; i < n; ++i) g[i] *= constant;
    // 3. Square it p times.
    for (int k = 0; k < squarings; ++k) square(*tables.product, g.data(), g.data());
    std::copy_n(g.begin(), n, out.begin());
}

}  // namespace

const ExpTables& expTables(int order) { return cachedExpTables<float>(order); }
const ExpTablesD& expTablesD(int order) { return cachedExpTables<double>(order); }

int squaringCount(const ExpOptions& options, double norm) {
    if (options.method == ExpMethod::kPs || options.method == ExpMethod::kOl) return 0;
    const double most = options.method == ExpMethod::kHybOl ? kLinearNorm : options.smooth ? 0.5 : 1;
    return std::min(kMaxSquarings, ceilLog2(norm / most));
}

void expOfLog(const ExpTables& tables, const ExpOptions& options, std::span<const float> log, std::span<float> out) {
    expAny(tables, options, log, out);
}
void expOfLog(const ExpTablesD& tables, const ExpOptions& options, std::span<const double> log, std::span<double> out) {
    expAny(tables, options, log, out);
}

void productChain(int order, std::span<const Cap> caps, std::span<double> out) {
    assert(order >= 1 && order <= kMaxOrder && int(out.size()) == coefficientCount(order));
    std::vector<Cap> largest_first(caps.begin(), caps.end());
    std::stable_sort(largest_first.begin(), largest_first.end(),
                     [](const Cap& a, const Cap& b) { return a.angle > b.angle; });
    std::vector<double> zonal(std::size_t(order), 0.0), cap(out.size()), product(out.size());
    std::fill(out.begin(), out.end(), 0.0);
    out[0] = kRootOfFourPi;
    for (std::size_t c = 0; c < largest_first.size(); ++c) {
        capVisibilityZonal(largest_first[c].angle, zonal);
        rotateZonal(zonal, largest_first[c].axis, cap);
        multiply(order, std::vector<double>(out.begin(), out.end()), order, cap, order, product);
        std::copy(product.begin(), product.end(), out.begin());
    }
}

}  // namespace penumbra
