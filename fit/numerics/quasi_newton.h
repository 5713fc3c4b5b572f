#pragma once
// Minimises functions of many variables by the BFGS and L-BFGS of Ceres.
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace penumbra {

// Returns the value at x and fills the gradient. The value may be infinite; the gradient is then not read.
using Objective = std::function<double(std::span<const double> x, std::span<double> gradient)>;

enum class QuasiNewton { kBfgs, kLbfgs };

struct SearchOptions {
    QuasiNewton method = QuasiNewton::kLbfgs;
    int iterations = 500;
    double least_decrease = 1e-6;  // stops when `window` iterations together gain no more than this part of the value
    int window = 5;
    double least_gradient = 0;                                 // stops where no entry of the gradient is larger
    double target = -std::numeric_limits<double>::infinity();  // stops as soon as the value is not above it
};

struct SearchResult {
    double value = std::numeric_limits<double>::infinity();  // infinite when it was not finite at the start
    int iterations = 0, evaluations = 0;
};

// Moves x towards a minimum. Every step satisfies the strong Wolfe conditions. The steps of L-BFGS use the last 20
// ones.
SearchResult minimise(const Objective& objective, const SearchOptions& options, std::vector<double>& x);

}  // namespace penumbra
