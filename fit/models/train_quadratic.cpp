#include "fit/models/train_quadratic.h"

#include <cmath>

#include "fit/models/input_pca.h"
#include "fit/models/linear_model.h"
#include "fit/models/quadratic_model.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// Exponents of alpha as a multiple of sqrt(frames), the singular value of an input with a root mean square of 1.
constexpr double kMinQuadraticExponent = -3, kMaxQuadraticExponent = 1.5, kQuadraticExponentStep = 0.25;

std::vector<double> alphaGrid(std::size_t frames) {
    std::vector<double> alphas;
    for (double e = kMinQuadraticExponent; e <= kMaxQuadraticExponent; e += kQuadraticExponentStep)
        alphas.push_back(std::pow(10.0, e) * std::sqrt(double(frames)));
    return alphas;
}

// Makes the model's inputs `scale` times as large.
void scaleInputs(double scale, ClusterModel& model) {
    for (std::vector<float>* part : {&model.input_basis, &model.input_min, &model.input_max})
        for (float& v : *part) v = float(scale * double(v));
}

}  // namespace

RegressionErrors trainQuadratic(const RegressionProblem& problem, ClusterModel& model) {
    // 1. Reduce the inputs and cross-validate every alpha on the expanded inputs.
    const InputPca inputs = makeInputPca(problem);
    const std::vector<double> alphas = alphaGrid(problem.train.size());
    const std::vector<double> errors =
        blockedErrors(inputs.weighted, problem.outputs.scores, problem.folds, problem.input_variance, alphas,
                      [](const Matrix& x) { return quadraticInputs(x); });
    // 2. When errors are equal, take the strongest prior. With nothing to validate on, the result is nearly the mean
    //    alone.
    std::size_t best = 0;
    for (std::size_t a = 1; a < errors.size(); ++a)
        if (errors[a] <= errors[best]) best = a;

    // 3. Scale the inputs so that the first has a root mean square of 1, and expand them.
    Matrix x = setInputs(inputs, componentsFor(inputs.pca, problem.input_variance), model);
    const double scale = expansionScale(inputs.pca, problem.train.size());
    asEigen(x) *= scale;
    scaleInputs(scale, model);
    // 4. Fit the ridge regression on all training rows and store it.
    const Matrix units = quadraticInputs(x), y = keptScores(problem);
    const Ridge ridge = fitRidge(units, y, alphas[best]);
    model.ridge = alphas[best];
    model.bias = toFloats(ridge.intercept);
    model.weights.clear();
    for (std::size_t k = 0; k < y.columns; ++k)
        for (std::size_t h = 0; h < units.columns; ++h) model.weights.push_back(float(ridge.weights(h, k)));
    const double loo = leaveOneOutError(ridge, units, y);
    return {errors[best], loo * loo * double(y.values.size())};
}

}  // namespace penumbra
