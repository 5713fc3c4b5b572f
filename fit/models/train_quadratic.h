#pragma once
// Input PCA and a ridge regression on the inputs and their products (quadratic_model.h).
#include "fit/models/regressor.h"

namespace penumbra {

RegressionErrors trainQuadratic(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
