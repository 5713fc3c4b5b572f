#pragma once
// Trains the quadratic model: input PCA and a ridge regression on the inputs and their products (quadratic_model.h).
#include "fit/models/regressor.h"

namespace penumbra {

// Chooses alpha by blocked cross-validation and sets the model's input PCA, weights, bias and ridge.
RegressionErrors trainQuadratic(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
