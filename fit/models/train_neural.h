#pragma once
// Input PCA and a tanh net (paper 000 eq 12 and 13), neurons and prior by cross-validation.
#include "fit/models/regressor.h"

namespace penumbra {

RegressionErrors trainNeural(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
