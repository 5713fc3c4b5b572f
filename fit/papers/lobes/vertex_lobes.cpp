#include "fit/papers/lobes/vertex_lobes.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/light/light_lobes.h"
#include "sh/zonal.h"

namespace penumbra {

namespace {

// Light has three colours, and visibility has one.
std::vector<double> greyLight(std::span<const double> values) {
    std::vector<double> sh;
    for (const double number : values) sh.insert(sh.end(), 3, number);
    return sh;
}

// Weight of the squares of the coefficients of the mean's lobes. Without it two lobes come near each other with large
// coefficients of opposite sign. Folds of training clips chose it over 1e-3, by little (NOTES.md).
constexpr double kMeanRidge = 1e-2;

// Returns the lobes of the mean over training frames.
LightLobesFit meanLobes(const LobeProblem& problem, const MatrixF& visibility, std::size_t vertex) {
    const std::size_t n = problem.coefficients();
    std::vector<double> mean(n);
    for (const std::size_t f : problem.train)
        for (std::size_t i = 0; i < n; ++i)
            mean[i] += double(visibility(f, vertex * n + i)) / double(problem.train.size());
    const std::vector<double> light = greyLight(mean);
    return fitLobesFrom(problem.order, light, fitLobes(problem.order, light, problem.lobes, LobeFit::kJoint).directions,
                        kMeanRidge);
}

}  // namespace

LobeChart::LobeChart(Vec3 a) : axis(normalized(toDouble(a))) {
    x = normalized(cross(std::abs(axis.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, axis));
    y = cross(axis, x);
}

std::array<double, 2> LobeChart::of(Vec3d direction) const {
    const double u = dot(direction, x), v = dot(direction, y), sine = std::hypot(u, v),
                 angle = std::atan2(sine, dot(direction, axis));
    return sine > 0 ? std::array{u / sine * angle, v / sine * angle} : std::array{angle, 0.0};
}

Vec3d LobeChart::at(double u, double v) const {
    const double angle = std::hypot(u, v);
    return angle > 0 ? axis * std::cos(angle) + (x * u + y * v) * (std::sin(angle) / angle) : axis;
}

VertexLobes fitVertexLobes(const LobeProblem& problem, const MatrixF& visibility, std::size_t vertex) {
    const std::size_t n = problem.coefficients(), bands = std::size_t(problem.order);
    VertexLobes lobes;
    const LightLobesFit mean = meanLobes(problem, visibility, vertex);
    for (const Vec3d axis : mean.directions) lobes.axes.push_back(toFloat(axis));
    lobes.values = Matrix(visibility.rows, problem.valuesOfVertex());
    const std::vector<LobeChart> charts(lobes.axes.begin(), lobes.axes.end());
    std::vector<Vec3d> start;
    for (const LobeChart& chart : charts) start.push_back(chart.axis);
    for (std::size_t f = 0; f < visibility.rows; ++f) {
        const std::span<const float> row = visibility.row(f).subspan(vertex * n, n);
        const std::vector<double> v(row.begin(), row.end());
        const LightLobesFit fit = fitLobesFrom(problem.order, greyLight(v), start, problem.ridge, mean.coefficients);
        double squares = 0;
        for (const double number : v) squares += number * number;
        lobes.error += fit.residual * fit.residual * squares;
        lobes.squares += squares;
        for (std::size_t d = 0; d < charts.size(); ++d) {
            const std::span<double> lobe = lobes.values.row(f).subspan(d * (2 + bands), 2 + bands);
            const std::array<double, 2> place = charts[d].of(fit.directions[d]);
            std::copy(place.begin(), place.end(), lobe.begin());
            for (std::size_t l = 0; l < bands; ++l) lobe[2 + l] = fit.coefficients[(d * bands + l) * 3];
        }
    }
    return lobes;
}

void lobesToVisibility(int order, std::span<const Vec3> axes, std::span<const double> values, std::span<double> out) {
    assert(out.size() == std::size_t(order) * std::size_t(order));
    const std::size_t each = 2 + std::size_t(order);
    std::vector<double> one(out.size());
    std::fill(out.begin(), out.end(), 0.0);
    for (std::size_t d = 0; d < axes.size(); ++d) {
        const std::span<const double> lobe = values.subspan(d * each, each);
        rotateZonal(lobe.subspan(2), LobeChart(axes[d]).at(lobe[0], lobe[1]), one);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += one[i];
    }
}

}  // namespace penumbra
