#include <algorithm>
#include <cmath>

#include "fit/models/neural_cross_validation.h"
#include "fit/models/trainers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// Cross-validation makes its own PCA of these components of the inputs. What they leave out is small compared with what
// that PCA drops.
constexpr double kValidatedVariance = 0.999;
// The prior of a fit that is to have none. A search needs some, or weights grow without end.
constexpr double kNoNeuralPrior = 1e-9;

void setNet(const TanhNet& net, ClusterModel& model) {
    model.hidden.clear(), model.weights.clear();
    for (std::size_t h = 0; h < net.neurons(); ++h) {
        model.hidden.insert(model.hidden.end(), net.hidden.row(h).begin(), net.hidden.row(h).end());
        model.hidden.push_back(float(net.hidden_bias[h]));
    }
    for (std::size_t k = 0; k < net.output.columns; ++k)
        for (std::size_t h = 0; h < net.neurons(); ++h) model.weights.push_back(float(net.output(h, k)));
    model.bias = toFloats(net.output_bias);
}

}  // namespace

RegressionErrors trainNeural(const RegressionProblem& problem, ClusterModel& model) {
    // 1. Reduce the inputs to the components that cross-validation starts from.
    const InputPca inputs = makeInputPca(problem);
    const std::size_t validated = std::min(
        componentsFor(inputs.pca, std::max(kValidatedVariance, problem.input_variance)), inputs.pca.energies.size());
    Matrix scores(inputs.weighted.rows, validated);
    asEigen(scores) = asEigen(inputs.pca.scores).leftCols(Eigen::Index(validated));

    // 2. Choose the number of neurons and the prior, then fit the net on all training rows.
    NetSearch search;
    search.input_variance = problem.input_variance;
    const Matrix y = keptScores(problem);
    const NetChoice choice = problem.prior ? chooseNet(scores, y, problem.folds, search)
                                           : NetChoice{std::ranges::max(search.neurons), kNoNeuralPrior, std::nan("")};
    const Matrix x = setInputs(inputs, componentsFor(inputs.pca, problem.input_variance), model);
    setNet(fitChosenNet(x, y, choice, search), model);
    model.ridge = choice.prior;

    // 3. The components that are not kept always count as error.
    RegressionErrors errors{choice.error, std::nan("")};
    for (std::size_t k = problem.components; k < problem.outputs.energies.size(); ++k)
        errors.cross_validated += problem.outputs.energies[k];
    return errors;
}

}  // namespace penumbra
