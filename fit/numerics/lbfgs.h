#pragma once
// Limited-memory BFGS with a line search for the weak Wolfe conditions (Nocedal and Wright, Numerical Optimization,
// algorithms 7.4 and 7.5). The problem may supply a diagonal in place of the usual multiple of the identity.
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace penumbra {

struct LbfgsProblem {
    // Returns the value at x and fills the gradient. The value may be infinite; the gradient is then not read.
    std::function<double(std::span<const double> x, std::span<double> gradient)> evaluate;
    // Fills an estimate of the second derivative by each variable at the last evaluated x. All must be positive. The
    // function may be empty.
    std::function<void(std::span<double> diagonal)> curvature;
};

struct LbfgsOptions {
    int iterations = 500;
    int memory = 20;
    double least_decrease = 1e-6;  // stops when 10 iterations together gain less than this part of the value
    double target = -std::numeric_limits<double>::infinity();  // stops as soon as the value is not above it
};

struct LbfgsResult {
    double value = 0;
    int iterations = 0, evaluations = 0;
};

// Moves x towards a minimum. Returns the value there and the numbers of iterations and evaluations.
LbfgsResult minimise(const LbfgsProblem& problem, const LbfgsOptions& options, std::vector<double>& x);

}  // namespace penumbra
