// Fits a sum of analytic lobes.
//
// Problem: widths and Fresnel terms make the sum nonlinear, with many local minima when two lobes overlap.
//
// Naive: start a nonlinear solver somewhere, and end in the nearest minimum.
//
// Here: widths and f0 come from a grid, and given these the colours are a least-squares problem of three unknowns a
// channel. Its sums are shared by all choices, so that every pair of the grid is tried. Only the weights of the norm
// are approximate there: they are those of a fit without error. The chosen lobes get their colours by reweighting until
// the norm is the true one. See docs/formulas.md, section 3 (lobes).

#include "formats/brdf/fit_lobes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/brdf/half_difference_table.h"

namespace penumbra {

namespace {

constexpr int kWidths = 24, kChannels = 3;
constexpr std::array<double, 5> kF0 = {0.02, 0.04, 0.1, 0.3, 1};
constexpr std::size_t kMaxSamplesRead = 4096;

// Candidate 0 is Lambert's model.
std::vector<BrdfLobe> candidateLobes() {
    std::vector<BrdfLobe> lobes(1);
    for (int k = 0; k < kWidths; ++k)
        for (double f0 : kF0)
            lobes.push_back({BrdfModel::kGgx, {float(std::pow(100.0, double(k) / (kWidths - 1) - 1)), float(f0)}, {}});
    for (BrdfLobe& lobe : lobes) lobe.color = {1, 1, 1};
    return lobes;
}

double valueOf(const BrdfLobe& lobe, const BrdfSample& sample) {
    return brdfFunction(lobe.model, {lobe.parameters[0], lobe.parameters[1]})(sample.wi, sample.wo);
}

// Least squares with up to three unknowns that are not negative: minimises x^T gram x - 2 x^T right.
struct SmallProblem {
    std::array<std::array<double, 3>, 3> gram{};
    std::array<double, 3> right{};

    // Improves one unknown after the other. Three unknowns settle in few rounds, and the result is never negative.
    std::array<double, 3> solve() const {
        std::array<double, 3> x{};
        for (int round = 0; round < 100; ++round) {
            const std::array<double, 3> before = x;
            for (std::size_t i = 0; i < 3; ++i) {
                double rest = right[i];
                for (std::size_t j = 0; j < 3; ++j)
                    if (j != i) rest -= gram[i][j] * x[j];
                x[i] = gram[i][i] > 0 ? std::max(0.0, rest / gram[i][i]) : 0;
            }
            if (x == before) break;
        }
        return x;
    }
    double objective(const std::array<double, 3>& x) const {
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            sum -= 2 * right[i] * x[i];
            for (std::size_t j = 0; j < 3; ++j) sum += gram[i][j] * x[i] * x[j];
        }
        return sum;
    }
};

// The samples with the values of every candidate. What lies far below `floor` counts as dark, however dark it is.
struct Fitting {
    std::vector<BrdfSample> samples;
    std::vector<BrdfLobe> candidates;
    std::vector<std::vector<double>> values;  // [candidates][samples]
    Vec3d floor;                              // a tenth of the median value

    // The square of (cbrt(fit) - cbrt(f)) / (fit - f), times the cosines: with these weights least squares has the
    // norm.
    double weight(std::size_t s, int channel, double fit) const {
        const double low = floor[channel], a = std::cbrt(fit + low), b = std::cbrt(samples[s].rgb[channel] + low);
        const double slope = 1 / (a * a + a * b + b * b);
        return samples[s].wi.z * samples[s].wo.z * slope * slope;
    }
};

double medianOf(const std::vector<BrdfSample>& samples, int channel) {
    std::vector<double> values;
    for (const BrdfSample& sample : samples) values.push_back(sample.rgb[channel]);
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

Fitting prepared(std::span<const BrdfSample> samples) {
    Fitting fitting;
    const std::size_t step = (samples.size() + kMaxSamplesRead - 1) / kMaxSamplesRead;
    for (std::size_t s = 0; s < samples.size(); s += step) fitting.samples.push_back(samples[s]);
    for (int c = 0; c < kChannels; ++c) fitting.floor[c] = std::max(0.1 * medianOf(fitting.samples, c), 1e-6);
    fitting.candidates = candidateLobes();
    for (const BrdfLobe& lobe : fitting.candidates) {
        fitting.values.emplace_back();
        for (const BrdfSample& sample : fitting.samples) fitting.values.back().push_back(valueOf(lobe, sample));
    }
    return fitting;
}

// The sums of every pair of candidates in one channel, with the weights of a fit without error.
struct Sums {
    std::vector<std::vector<double>> gram;
    std::vector<double> right;
};

Sums sumsOf(const Fitting& fitting, int channel) {
    const std::size_t count = fitting.candidates.size(), samples = fitting.samples.size();
    Sums sums{std::vector(count, std::vector<double>(count)), std::vector<double>(count)};
    std::vector<double> weighted(samples);
    for (std::size_t a = 0; a < count; ++a) {
        for (std::size_t s = 0; s < samples; ++s) {
            const double f = fitting.samples[s].rgb[channel];
            weighted[s] = fitting.weight(s, channel, f) * fitting.values[a][s];
            sums.right[a] += weighted[s] * f;
        }
        for (std::size_t b = 0; b <= a; ++b) {
            double sum = 0;
            for (std::size_t s = 0; s < samples; ++s) sum += weighted[s] * fitting.values[b][s];
            sums.gram[a][b] = sums.gram[b][a] = sum;
        }
    }
    return sums;
}

using Choice = std::array<std::size_t, 3>;  // Lambert, and two candidates that may be the same

SmallProblem problemOf(const Sums& sums, const Choice& choice) {
    SmallProblem problem;
    const std::size_t count = choice[1] == choice[2] ? 2 : 3;
    for (std::size_t i = 0; i < count; ++i) {
        problem.right[i] = sums.right[choice[i]];
        for (std::size_t j = 0; j < count; ++j) problem.gram[i][j] = sums.gram[choice[i]][choice[j]];
    }
    return problem;
}

// Tries every pair of the grid.
Choice bestChoice(const Fitting& fitting) {
    std::array<Sums, kChannels> sums;
    for (int c = 0; c < kChannels; ++c) sums[std::size_t(c)] = sumsOf(fitting, c);
    Choice best{0, 1, 1};
    double least = 0;
    for (std::size_t a = 1; a < fitting.candidates.size(); ++a)
        for (std::size_t b = a; b < fitting.candidates.size(); ++b) {
            double objective = 0;
            for (const Sums& of_channel : sums) {
                const SmallProblem problem = problemOf(of_channel, {0, a, b});
                objective += problem.objective(problem.solve());
            }
            if (objective < least) {
                least = objective;
                best = {0, a, b};
            }
        }
    return best;
}

// The colours of the chosen candidates in the norm itself: the weights of each round are those of the last fit.
std::array<double, 3> coloursOf(const Fitting& fitting, const Choice& choice, int channel) {
    const std::size_t count = choice[1] == choice[2] ? 2 : 3;
    std::vector<double> fit;
    for (const BrdfSample& sample : fitting.samples) fit.push_back(sample.rgb[channel]);
    std::array<double, 3> x{};
    for (int round = 0; round < 20; ++round) {
        SmallProblem problem;
        for (std::size_t s = 0; s < fit.size(); ++s) {
            const double weight = fitting.weight(s, channel, fit[s]);
            for (std::size_t i = 0; i < count; ++i) {
                const double weighted = weight * fitting.values[choice[i]][s];
                problem.right[i] += weighted * fitting.samples[s].rgb[channel];
                for (std::size_t j = 0; j < count; ++j) problem.gram[i][j] += weighted * fitting.values[choice[j]][s];
            }
        }
        x = problem.solve();
        for (std::size_t s = 0; s < fit.size(); ++s) {
            fit[s] = 0;
            for (std::size_t i = 0; i < count; ++i) fit[s] += x[i] * fitting.values[choice[i]][s];
        }
    }
    return x;
}

}  // namespace

std::vector<BrdfLobe> fitLobes(std::span<const BrdfSample> samples) {
    if (samples.empty()) return {{BrdfModel::kLambert, {}, {0, 0, 0}}};
    // 1. Choose widths and Fresnel terms.
    const Fitting fitting = prepared(samples);
    const Choice choice = bestChoice(fitting);
    // 2. Find the colours, and leave out what is black.
    std::array<Vec3d, 3> colors;
    for (int c = 0; c < kChannels; ++c) {
        const std::array<double, 3> x = coloursOf(fitting, choice, c);
        for (std::size_t i = 0; i < 3; ++i) colors[i][c] = x[i];
    }
    std::vector<BrdfLobe> lobes;
    for (std::size_t i = 0; i < 3; ++i) {
        BrdfLobe lobe = fitting.candidates[choice[i]];
        lobe.color = toFloat(colors[i]);
        if (lobe.color != Vec3{}) lobes.push_back(lobe);
    }
    if (lobes.empty()) lobes.push_back({BrdfModel::kLambert, {}, {0, 0, 0}});
    return lobes;
}

std::vector<BrdfSample> samplesOf(const RgbBrdf& brdf) {
    constexpr int kHalf = 32, kDifference = 16, kAzimuths = 6;
    constexpr double kRightAngle = std::numbers::pi / 2;
    std::vector<BrdfSample> samples;
    for (int h = 0; h < kHalf; ++h)
        for (int d = 0; d < kDifference; ++d)
            for (int p = 0; p < kAzimuths; ++p) {
                const double root = (h + 0.5) / kHalf;
                const auto [wi, wo] =
                    directionsOf({kRightAngle * root * root * root, kRightAngle * (d + 0.5) / kDifference,
                                  kRightAngle * (p + 0.5) / kAzimuths});
                if (!(wi.z > 0 && wo.z > 0)) continue;
                // Anisotropic materials are seen from all sides: each pair is turned by another angle.
                const double turn = std::numbers::phi * 2 * std::numbers::pi * double(samples.size());
                const double c = std::cos(turn), s = std::sin(turn);
                const auto turned = [&](Vec3d v) { return Vec3d{c * v.x - s * v.y, s * v.x + c * v.y, v.z}; };
                const Vec3d f = brdf.eval(turned(wi), turned(wo));
                samples.push_back(
                    {turned(wi), turned(wo), {std::max(0.0, f.x), std::max(0.0, f.y), std::max(0.0, f.z)}});
            }
    return samples;
}

// D is a2 / (pi (a2 cos^2 + sin^2)^2), a half of that at 0 where a2 + (1 - a2) sin^2 is sqrt(2) a2.
double halfWidth(const BrdfLobe& ggx) {
    const double a2 = double(ggx.parameters[0]) * ggx.parameters[0];
    return std::asin(std::min(1.0, std::sqrt(a2 * (std::numbers::sqrt2 - 1) / std::max(1 - a2, 1e-9))));
}

}  // namespace penumbra
