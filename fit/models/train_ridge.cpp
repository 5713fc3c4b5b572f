#include <cmath>

#include "fit/models/linear_model.h"
#include "fit/models/trainers.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/ridge_path.h"

namespace penumbra {

namespace {

// Exponents of alpha as a multiple of sqrt(rows), the singular value of an input with a root mean square of 1.
constexpr double kMinExpandedExponent = -3, kMaxExpandedExponent = 1.5, kExpandedExponentStep = 0.25;

}  // namespace

Matrix quadraticInputs(const Matrix& inputs) {
    Matrix out(inputs.rows, quadraticUnits(inputs.columns));
    for (std::size_t r = 0; r < inputs.rows; ++r) {
        const std::span<const double> x = inputs.row(r);
        std::copy(x.begin(), x.end(), out.row(r).begin());
        std::size_t at = x.size();
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = i; j < x.size(); ++j) out(r, at++) = x[i] * x[j];
    }
    return out;
}

std::vector<double> ridgePriors(int degree, const InputPca& inputs, std::size_t rows) {
    if (degree == 1) return alphaGrid(inputs.pca.energies.empty() ? 0 : std::sqrt(inputs.pca.energies[0]));
    std::vector<double> alphas;
    for (double e = kMinExpandedExponent; e <= kMaxExpandedExponent; e += kExpandedExponentStep)
        alphas.push_back(std::pow(10.0, e) * std::sqrt(double(rows)));
    return alphas;
}

RegressionErrors trainRidge(const RegressionProblem& problem, int degree, ClusterModel& model) {
    // 1. Reduce the inputs and cross-validate every alpha. With nothing to validate on, the result is nearly the mean
    //    alone.
    const InputPca inputs = makeInputPca(problem);
    const std::vector<double> alphas = ridgePriors(degree, inputs, problem.train.size());
    const Expansion expand = degree == 1 ? Expansion{} : Expansion{quadraticInputs};
    const std::vector<double> errors =
        blockedErrors(inputs.weighted, problem.outputs.scores, problem.folds, problem.input_variance, alphas, expand);
    const std::size_t best = strongestOfBest(errors);
    // 2. Scale the inputs that are expanded.
    Matrix x = setInputs(inputs, componentsFor(inputs.pca, problem.input_variance), model);
    if (expand) {
        const double scale = expansionScale(inputs.pca, problem.train.size());
        asEigen(x) *= scale;
        for (std::vector<float>* part : {&model.input_basis, &model.input_min, &model.input_max})
            for (float& v : *part) v = float(scale * double(v));
        x = expand(x);
    }
    // 3. Fit the ridge regression on all training rows and store it.
    const Matrix y = keptScores(problem);
    const Ridge ridge = fitRidge(x, y, alphas[best]);
    model.ridge = alphas[best];
    model.bias = toFloats(ridge.intercept);
    model.weights.clear();
    for (std::size_t k = 0; k < y.columns; ++k)
        for (std::size_t h = 0; h < x.columns; ++h) model.weights.push_back(float(ridge.weights(h, k)));
    const double loo = leaveOneOutError(ridge, x, y);
    return {errors[best], loo * loo * double(y.values.size())};
}

}  // namespace penumbra
