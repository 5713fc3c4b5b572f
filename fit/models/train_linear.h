#pragma once
// Input PCA and ridge regression (paper 000 section 5.2-5.3, paper 002 section 4.2).
#include "fit/models/regressor.h"

namespace penumbra {

RegressionErrors trainLinear(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
