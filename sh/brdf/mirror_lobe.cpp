#include "sh/brdf/mirror_lobe.h"

#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

using Polynomial = std::vector<double>;  // ascending powers of z

Polynomial product(const Polynomial& a, const Polynomial& b) {
    Polynomial p(a.size() + b.size() - 1);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) p[i + j] += a[i] * b[j];
    return p;
}

// Returns P_l^m without its factor sin^m and without the Condon-Shortley sign, by the usual recurrence in l.
Polynomial legendre(int l, int m) {
    Polynomial before{}, now{1};
    for (int k = 1; k < 2 * m; k += 2) now[0] *= k;
    for (int k = m + 1; k <= l; ++k) {
        Polynomial next(now.size() + 1);
        for (std::size_t i = 0; i < now.size(); ++i) next[i + 1] = (2 * k - 1) * now[i] / (k - m);
        for (std::size_t i = 0; i < before.size(); ++i) next[i] -= (k + m - 1) * before[i] / (k - m);
        before = std::move(now);
        now = std::move(next);
    }
    return now;
}

// With the azimuth integrated, y_lm has this factor for either sign of m.
double norm(int l, int m) {
    double ratio = (2 * l + 1) / 2.0;
    for (int k = l - m + 1; k <= l + m; ++k) ratio /= k;
    return std::sqrt(ratio);
}

}  // namespace

MirrorLobeSum::MirrorLobeSum(int rows, int columns) : degree_(rows + columns - 2) {
    assert(rows >= 1 && rows <= kMaxOrder && columns >= 1 && columns <= kMaxOrder);
    for (int l = 0; l < rows; ++l)
        for (int m = -l; m <= l; ++m)
            for (int k = std::abs(m); k < columns; ++k) {
                entries_.push_back({std::uint16_t(shIndex(l, m)), std::uint16_t(shIndex(k, m))});
                Polynomial p = product(legendre(l, std::abs(m)), legendre(k, std::abs(m)));
                for (int s = 0; s < std::abs(m); ++s) p = product(p, {1, 0, -1});
                p.resize(momentCount());
                for (const double c : p) coefficients_.push_back(c * norm(l, std::abs(m)) * norm(k, std::abs(m)));
            }
}

void MirrorLobeSum::evaluate(std::span<const double> moments, std::span<double> values) const {
    assert(moments.size() == momentCount() && values.size() == entries_.size());
    const double* c = coefficients_.data();
    for (double& value : values) {
        value = 0;
        for (const double moment : moments) value += *c++ * moment;
    }
}

std::vector<double> mirrorLobeMatrix(int rows, int columns, std::span<const double> moments) {
    const MirrorLobeSum sum(rows, columns);
    std::vector<double> values(sum.entries().size());
    sum.evaluate(moments, values);
    const auto width = std::size_t(coefficientCount(columns));
    std::vector<double> matrix(std::size_t(coefficientCount(rows)) * width);
    for (std::size_t e = 0; e < values.size(); ++e) matrix[sum.entries()[e].i * width + sum.entries()[e].j] = values[e];
    return matrix;
}

namespace {

// f = (a + 1)/(2 pi) z^a.
void phongMoments(double exponent, std::span<double> moments) {
    for (std::size_t k = 0; k < moments.size(); ++k)
        moments[k] = (exponent + 1) / (2 * std::numbers::pi * (exponent + 1 + double(k)));
}

// f = D/4 with GGX's D of the half vector, whose squared cosine is (1 + z)/2. With u = 1/(a^2 (1 + z)/2 + (1 - z)/2),
// f dz = a^2/(2 pi (1 - a^2)) du. The lobe is as narrow as a^2, but in log u everything is smooth.
void ggxMoments(double alpha, std::span<double> moments) {
    static const std::vector<WeightedNumber> kNodes = gaussInterval(48);
    const double a2 = alpha * alpha, low = std::log(2 / (1 + a2)), high = -std::log(a2);
    for (double& moment : moments) moment = 0;
    for (const auto& [x, weight] : kNodes) {
        const double u = std::exp(low + x * (high - low));
        // At a = 1 the interval is empty and the factor infinite; together they tend to the constant D = 1/pi.
        const double z = a2 < 1 - 1e-9 ? 1 - 2 * (1 / u - a2) / (1 - a2) : x;
        double term = a2 < 1 - 1e-9 ? weight * (high - low) * u * a2 / (2 * std::numbers::pi * (1 - a2))
                                    : weight / (4 * std::numbers::pi);
        for (double& moment : moments) {
            moment += term;
            term *= z;
        }
    }
}

}  // namespace

bool isMirrorLobe(BrdfModel model) { return model == BrdfModel::kPhongLive || model == BrdfModel::kGgxLive; }

void mirrorLobeMoments(BrdfModel model, double parameter, std::span<double> moments) {
    assert(isMirrorLobe(model));
    model == BrdfModel::kPhongLive ? phongMoments(parameter, moments) : ggxMoments(parameter, moments);
}

}  // namespace penumbra
