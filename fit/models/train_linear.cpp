#include "fit/models/train_linear.h"

#include <cmath>

#include "fit/models/input_pca.h"
#include "fit/models/linear_model.h"
#include "fit/numerics/cross_validation.h"
#include "fit/numerics/eigen_map.h"
#include "fit/numerics/ridge_path.h"

namespace penumbra {

RegressionErrors trainLinear(const RegressionProblem& problem, ClusterModel& model) {
    // 1. Reduce the inputs and cross-validate every alpha.
    const InputPca inputs = makeInputPca(problem);
    const std::vector<double> alphas = alphaGrid(inputs.pca.energies.empty() ? 0 : std::sqrt(inputs.pca.energies[0]));
    const std::vector<double> errors =
        blockedErrors(inputs.weighted, problem.outputs.scores, problem.folds, problem.input_variance, alphas);
    // 2. When errors are equal, take the strongest prior. With nothing to validate on, the result is nearly the mean
    //    alone.
    std::size_t best = 0;
    for (std::size_t a = 1; a < errors.size(); ++a)
        if (errors[a] <= errors[best]) best = a;

    // 3. Fit the ridge regression on all training rows and store it.
    const Matrix x = setInputs(inputs, componentsFor(inputs.pca, problem.input_variance), model);
    const Matrix y = keptScores(problem);
    const Ridge ridge = fitRidge(x, y, alphas[best]);
    model.ridge = alphas[best];
    model.bias = toFloats(ridge.intercept);
    for (std::size_t k = 0; k < y.columns; ++k)
        for (std::size_t i = 0; i < x.columns; ++i) model.weights.push_back(float(ridge.weights(i, k)));
    const double loo = leaveOneOutError(ridge, x, y);
    return {errors[best], loo * loo * double(y.values.size())};
}

}  // namespace penumbra
