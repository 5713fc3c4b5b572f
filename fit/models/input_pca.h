#pragma once
// Makes the reduced inputs of the linear, quadratic and neural models (Nowrouzezahrai 2009 section 5.1).
#include "fit/models/regressor.h"

namespace penumbra {

// N counts raw features, train counts training rows.
struct InputPca {
    std::vector<double> mean, weights;  // [N] mean of each raw feature, and its factor before the PCA
    Matrix weighted;                    // [train, N] (raw - mean) * weights
    Pca pca;                            // PCA of `weighted`
};
// Weights the raw features of the training rows and computes their principal components.
InputPca makeInputPca(const RegressionProblem& problem);

// Sets the model's feature_mean, its input_basis (the first `count` PCA rows, multiplied by the weights) and the range
// of its inputs. Returns the training inputs [train, count].
Matrix setInputs(const InputPca& inputs, std::size_t count, ClusterModel& model);

}  // namespace penumbra
