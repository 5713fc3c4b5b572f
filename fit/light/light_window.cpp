#include "fit/light/light_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "fit/light/light_lobes.h"
#include "sh/key_values.h"
#include "sh/light/sharpest_window.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

WindowChoice parseWindow(const std::string& text) {
    if (text == "none") return {WindowChoice::Mode::kNone, 0};
    if (text == "auto") return {WindowChoice::Mode::kAuto, 0};
    if (text == "always") return {WindowChoice::Mode::kAlways, 0};
    try {
        return {WindowChoice::Mode::kLambda, parseNumber("window", text, 0, 1000)};
    } catch (const std::invalid_argument&) {
        throw std::invalid_argument("window must be none, auto, always or a number from 0 to 1000, not '" + text + "'");
    }
}

namespace {

void applyWindow(std::span<const double> weights, std::span<double> sh) {
    for (std::size_t l = 0; l < weights.size(); ++l)
        for (std::size_t i = 3 * l * l; i < 3 * (l + 1) * (l + 1); ++i) sh[i] *= weights[l];
}

double radianceAt(int order, std::span<const double> sh, std::size_t channel, Vec3d direction) {
    std::array<double, coefficientCount(kMaxOrder)> y;
    const auto count = std::size_t(coefficientCount(order));
    evalBasis(order, direction, std::span(y).first(count));
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += sh[3 * i + channel] * y[i];
    return sum;
}

// Goes downhill from `direction` by a pattern search in the tangent plane. The step halves when no neighbour is lower.
double refineMinimum(int order, std::span<const double> sh, std::size_t channel, Vec3d direction, double value) {
    for (double step = 0.04; step > 1e-5;) {
        const Vec3d a = normalized(cross(direction, std::abs(direction.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                    b = cross(direction, a);
        bool lower = false;
        for (Vec3d move : {a, -a, b, -b}) {
            const Vec3d next = normalized(direction + step * move);
            const double found = radianceAt(order, sh, channel, next);
            if (found < value) {
                value = found, direction = next, lower = true;
                break;
            }
        }
        if (!lower) step /= 2;
    }
    return value;
}

}  // namespace

double leastRadiance(int order, std::span<const double> sh) {
    static const std::vector<Vec3d> directions = fibonacciSphere(4096);
    constexpr std::size_t kRefined = 4;
    double least = 1;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const double mean = sh[channel] / std::sqrt(4 * std::numbers::pi);
        if (!(mean > 0)) continue;
        std::vector<std::pair<double, std::size_t>> values;
        // 1. Evaluate all directions and keep the lowest.
        for (std::size_t i = 0; i < directions.size(); ++i)
            values.push_back({radianceAt(order, sh, channel, directions[i]), i});
        std::partial_sort(values.begin(), values.begin() + kRefined, values.end());
        // 2. Refine these.
        for (std::size_t k = 0; k < kRefined; ++k)
            least = std::min(least,
                             refineMinimum(order, sh, channel, directions[values[k].second], values[k].first) / mean);
    }
    return least;
}

namespace {

// Returns w_l = 1 / (1 + lambda l^2 (l+1)^2).
std::vector<double> sloanWindow(int order, double lambda) {
    std::vector<double> weights;
    for (int l = 0; l < order; ++l) weights.push_back(1 / (1 + lambda * l * l * (l + 1.0) * (l + 1.0)));
    return weights;
}

// Returns the sharpest window, mixed with no window.
std::vector<double> blendedWindow(int order, double share) {
    std::vector<double> weights;
    for (double w : sharpestWindow(order)) weights.push_back(1 - share * (1 - w));
    return weights;
}

std::vector<double> windowed(std::span<const double> sh, std::span<const double> weights) {
    std::vector<double> out(sh.begin(), sh.end());
    applyWindow(weights, out);
    return out;
}

// Returns the window that changes irradiance least while ringing stays within kMaxRinging. There are two families,
// each with a parameter from 0 (no window) to 1 (suits any light; a lambda of 1000 leaves 0.02% of band 1). Sloan's
// family is better against a little ringing, the other against much.
std::vector<double> leastWindow(int order, std::span<const double> sh) {
    const auto sloan = [order](double s) { return sloanWindow(order, s > 0 ? std::pow(10.0, 9 * s - 6) : 0); };
    const auto blend = [order](double s) { return blendedWindow(order, s); };
    std::vector<double> best;
    double least_change = 0;
    for (const std::function<std::vector<double>(double)>& family :
         std::initializer_list<std::function<std::vector<double>(double)>>{sloan, blend}) {
        // 1. Bisect for the least parameter of the family that suffices.
        double low = 0, high = 1;
        while (high - low > 1e-4) {
            const double middle = (low + high) / 2;
            (leastRadiance(order, windowed(sh, family(middle))) < -kMaxRinging ? low : high) = middle;
        }
        // 2. Keep the family that changes irradiance less.
        const double change = irradianceDifference(order, windowed(sh, family(high)), sh);
        if (best.empty() || change < least_change) best = family(high), least_change = change;
    }
    return best;
}

}  // namespace

WindowReport windowLight(int order, const WindowChoice& choice, std::span<double> sh) {
    const std::vector<double> before(sh.begin(), sh.end());
    WindowReport report;
    report.weights.assign(std::size_t(order), 1.0);
    report.least_before = report.least_after = leastRadiance(order, sh);
    if (choice.mode == WindowChoice::Mode::kLambda) report.weights = sloanWindow(order, choice.lambda);
    if (choice.mode == WindowChoice::Mode::kAlways && report.least_before < -kMaxRinging)
        report.weights = leastWindow(order, sh);
    if (!report.any()) return report;
    applyWindow(report.weights, sh);
    report.least_after = leastRadiance(order, sh);
    report.irradiance_change = irradianceDifference(order, sh, before);
    return report;
}

}  // namespace penumbra
