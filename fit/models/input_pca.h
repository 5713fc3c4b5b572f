#pragma once
// The reduced inputs of the linear, quadratic and neural models (paper 000 section 5.1).
#include "fit/models/regressor.h"

namespace penumbra {

struct InputPca {
    std::vector<double> mean, weights;  // [N] of the raw features
    Matrix weighted;                    // [train, N] (raw - mean) weights
    Pca pca;                            // of `weighted`
};
InputPca makeInputPca(const RegressionProblem& problem);

// Sets the model's feature_mean, input_basis (the first `count` PCA rows, the weights multiplied in) and the inputs'
// range; returns the training inputs [train, count].
Matrix setInputs(const InputPca& inputs, std::size_t count, ClusterModel& model);

}  // namespace penumbra
