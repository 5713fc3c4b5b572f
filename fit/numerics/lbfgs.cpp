#include "fit/numerics/lbfgs.h"

#include <Eigen/Core>
#include <cmath>
#include <deque>

namespace penumbra {

namespace {

constexpr double kSufficientDecrease = 1e-4, kCurvature = 0.9;  // the usual Wolfe constants
constexpr int kMostTrials = 20;                                 // of one line search
constexpr int kWindow = 10;                                     // iterations over which progress is judged
constexpr int kCurvatureAge = 10;                               // iterations before the diagonal is made anew

using Vector = Eigen::VectorXd;
using View = Eigen::Map<const Vector>;

View viewOf(std::span<const double> v) { return {v.data(), Eigen::Index(v.size())}; }

struct Pair {
    Vector step, change;  // of x, of the gradient
    double inner;         // step . change > 0
};

// -H gradient, H from the pairs and the diagonal.
Vector direction(const std::deque<Pair>& pairs, std::span<const double> diagonal, std::span<const double> gradient) {
    Vector q = viewOf(gradient), factors(Eigen::Index(pairs.size()));
    for (std::size_t p = pairs.size(); p-- > 0;) {
        factors[Eigen::Index(p)] = pairs[p].step.dot(q) / pairs[p].inner;
        q -= factors[Eigen::Index(p)] * pairs[p].change;
    }
    if (!pairs.empty()) q *= pairs.back().inner / pairs.back().change.cwiseAbs2().cwiseQuotient(viewOf(diagonal)).sum();
    q = q.cwiseQuotient(viewOf(diagonal)).eval();
    for (std::size_t p = 0; p < pairs.size(); ++p)
        q += (factors[Eigen::Index(p)] - pairs[p].change.dot(q) / pairs[p].inner) * pairs[p].step;
    return -q;
}

struct Point {
    std::vector<double> x, gradient;
    double value = 0;
};

// Where the parabola through both values and the slope at `low` has its minimum, kept off the ends.
double interpolate(double low, double low_value, double low_slope, double high, double high_value) {
    const double width = high - low;
    const double bend = (high_value - low_value - low_slope * width) / (width * width);  // of the parabola
    double at = bend > 0 ? -low_slope / (2 * bend) : width / 2;
    if (!std::isfinite(at)) at = width / 2;
    return low + std::min(std::max(at, 0.1 * width), 0.9 * width);
}

// Bracketing and interpolation for the weak Wolfe conditions. False when no trial decreased the value.
bool lineSearch(const LbfgsProblem& problem, const Point& from, const Vector& along, Point& to, int& evaluations) {
    const double slope = viewOf(from.gradient).dot(along);
    if (!(slope < 0)) return false;
    double low = 0, low_value = from.value, low_slope = slope, high = std::numeric_limits<double>::infinity(), step = 1;
    to.x.resize(from.x.size());
    to.gradient.resize(from.x.size());
    for (int trial = 0; trial < kMostTrials; ++trial) {
        for (std::size_t i = 0; i < to.x.size(); ++i) to.x[i] = from.x[i] + step * along[Eigen::Index(i)];
        to.value = problem.evaluate(to.x, to.gradient);
        ++evaluations;
        if (!(to.value <= from.value + kSufficientDecrease * step * slope)) {
            high = step;
            step = std::isfinite(to.value) ? interpolate(low, low_value, low_slope, high, to.value) : (low + high) / 2;
            continue;
        }
        const double to_slope = viewOf(to.gradient).dot(along);
        if (to_slope >= kCurvature * slope) return true;
        low = step, low_value = to.value, low_slope = to_slope;
        step = std::isfinite(high) ? (low + high) / 2 : 2 * step;
    }
    return to.value < from.value;
}

void remember(std::deque<Pair>& pairs, const Point& before, const Point& after, int memory) {
    Pair pair{viewOf(after.x) - viewOf(before.x), viewOf(after.gradient) - viewOf(before.gradient), 0};
    pair.inner = pair.step.dot(pair.change);
    if (!(pair.inner > 1e-14 * pair.change.squaredNorm())) return;
    pairs.push_back(std::move(pair));
    if (pairs.size() > std::size_t(memory)) pairs.pop_front();
}

}  // namespace

LbfgsResult minimise(const LbfgsProblem& problem, const LbfgsOptions& options, std::vector<double>& x) {
    Point at{x, std::vector<double>(x.size()), 0}, next;
    at.value = problem.evaluate(at.x, at.gradient);
    LbfgsResult result{at.value, 0, 1};
    std::vector<double> diagonal(x.size(), 1.0), values{at.value};
    std::deque<Pair> pairs;
    while (result.iterations < options.iterations && at.value > options.target) {
        if (problem.curvature && result.iterations % kCurvatureAge == 0) problem.curvature(diagonal);
        if (!lineSearch(problem, at, direction(pairs, diagonal, at.gradient), next, result.evaluations)) {
            if (pairs.empty()) break;
            pairs.clear();  // once more along the scaled gradient
            continue;
        }
        remember(pairs, at, next, options.memory);
        std::swap(at, next);
        ++result.iterations;
        values.push_back(at.value);
        if (values.size() > kWindow) {
            const double gained = values[values.size() - 1 - kWindow] - at.value;
            if (gained <= options.least_decrease * std::abs(at.value)) break;
        }
    }
    result.value = at.value;
    x = at.x;
    return result;
}

}  // namespace penumbra
