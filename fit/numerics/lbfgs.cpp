#include "fit/numerics/lbfgs.h"

#include <Eigen/Core>
#include <cmath>
#include <deque>

namespace penumbra {

namespace {

constexpr double kSufficientDecrease = 1e-4, kCurvature = 0.9;  // the usual Wolfe constants
constexpr int kMostTrials = 20;                                 // trials in one line search
constexpr int kWindow = 10;                                     // iterations over which progress is judged
constexpr int kCurvatureAge = 10;                               // iterations after which the diagonal is computed again

using Vector = Eigen::VectorXd;
using View = Eigen::Map<const Vector>;

View viewOf(std::span<const double> v) { return {v.data(), Eigen::Index(v.size())}; }

// A step and the change of the gradient along it, which tell the curvature in that direction.
struct Pair {
    Vector step, change;  // change of x, change of the gradient
    double inner;         // step . change, which is positive
};

// Returns -H gradient, where H is the inverse Hessian as estimated from the pairs and the diagonal (algorithm 7.4, the
// two-loop recursion).
Vector direction(const std::deque<Pair>& pairs, std::span<const double> diagonal, std::span<const double> gradient) {
    // 1. From the newest pair to the oldest.
    Vector q = viewOf(gradient), factors(Eigen::Index(pairs.size()));
    for (std::size_t p = pairs.size(); p-- > 0;) {
        factors[Eigen::Index(p)] = pairs[p].step.dot(q) / pairs[p].inner;
        q -= factors[Eigen::Index(p)] * pairs[p].change;
    }
    // 2. Apply the inverse of the diagonal, scaled to the curvature along the newest step.
    if (!pairs.empty()) q *= pairs.back().inner / pairs.back().change.cwiseAbs2().cwiseQuotient(viewOf(diagonal)).sum();
    q = q.cwiseQuotient(viewOf(diagonal)).eval();
    // 3. From the oldest pair to the newest.
    for (std::size_t p = 0; p < pairs.size(); ++p)
        q += (factors[Eigen::Index(p)] - pairs[p].change.dot(q) / pairs[p].inner) * pairs[p].step;
    return -q;
}

struct Point {
    std::vector<double> x, gradient;
    double value = 0;
};

// Returns where the parabola through both values and the slope at `low` has its minimum. The result stays a tenth of
// the interval away from both ends.
double interpolate(double low, double low_value, double low_slope, double high, double high_value) {
    const double width = high - low;
    // Second-order coefficient of the parabola.
    const double bend = (high_value - low_value - low_slope * width) / (width * width);
    double at = bend > 0 ? -low_slope / (2 * bend) : width / 2;
    if (!std::isfinite(at)) at = width / 2;
    return low + std::min(std::max(at, 0.1 * width), 0.9 * width);
}

// Looks for a step that satisfies the weak Wolfe conditions, by bracketing and interpolation. Returns false when no
// trial decreased the value.
bool lineSearch(const LbfgsProblem& problem, const Point& from, const Vector& along, Point& to, int& evaluations) {
    const double slope = viewOf(from.gradient).dot(along);
    if (!(slope < 0)) return false;
    double low = 0, low_value = from.value, low_slope = slope, high = std::numeric_limits<double>::infinity(), step = 1;
    to.x.resize(from.x.size());
    to.gradient.resize(from.x.size());
    for (int trial = 0; trial < kMostTrials; ++trial) {
        // 1. Evaluate the trial step.
        for (std::size_t i = 0; i < to.x.size(); ++i) to.x[i] = from.x[i] + step * along[Eigen::Index(i)];
        to.value = problem.evaluate(to.x, to.gradient);
        ++evaluations;
        // 2. The value did not fall enough: the step is too long.
        if (!(to.value <= from.value + kSufficientDecrease * step * slope)) {
            high = step;
            step = std::isfinite(to.value) ? interpolate(low, low_value, low_slope, high, to.value) : (low + high) / 2;
            continue;
        }
        // 3. The slope is still steep: the step is too short. Otherwise it is right.
        const double to_slope = viewOf(to.gradient).dot(along);
        if (to_slope >= kCurvature * slope) return true;
        low = step, low_value = to.value, low_slope = to_slope;
        step = std::isfinite(high) ? (low + high) / 2 : 2 * step;
    }
    return to.value < from.value;
}

// Adds a pair and drops the oldest when there are more than `memory`. A pair without positive curvature is left out.
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
        // 1. Renew the diagonal now and then.
        if (problem.curvature && result.iterations % kCurvatureAge == 0) problem.curvature(diagonal);
        // 2. Search along the direction. If that fails, forget the pairs and try once more along the scaled gradient.
        if (!lineSearch(problem, at, direction(pairs, diagonal, at.gradient), next, result.evaluations)) {
            if (pairs.empty()) break;
            pairs.clear();
            continue;
        }
        // 3. Take the step and learn from it.
        remember(pairs, at, next, options.memory);
        std::swap(at, next);
        ++result.iterations;
        values.push_back(at.value);
        // 4. Stop when the last iterations gained too little.
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
