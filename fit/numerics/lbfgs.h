#pragma once
// Limited-memory BFGS with a diagonal that the problem may supply in place of the usual multiple of the identity
// (Nocedal and Wright, Numerical Optimization, algorithms 7.4 and 7.5) and a line search for the weak Wolfe conditions.
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace penumbra {

struct LbfgsProblem {
    // Value at x; fills the gradient. May be infinite (then the gradient is not read).
    std::function<double(std::span<const double> x, std::span<double> gradient)> evaluate;
    // Estimate of the second derivative by each variable at the last evaluated x, all > 0. May be empty.
    std::function<void(std::span<double> diagonal)> curvature;
};

struct LbfgsOptions {
    int iterations = 500;
    int memory = 20;
    double least_decrease = 1e-6;  // stops when 10 iterations together gain less than this part of the value
    double target = -std::numeric_limits<double>::infinity();  // stops when the value is not above it
};

struct LbfgsResult {
    double value = 0;
    int iterations = 0, evaluations = 0;
};

LbfgsResult minimise(const LbfgsProblem& problem, const LbfgsOptions& options, std::vector<double>& x);

}  // namespace penumbra
