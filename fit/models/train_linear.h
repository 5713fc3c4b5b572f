#pragma once
// Trains the linear model: input PCA and ridge regression (Nowrouzezahrai 2009 sections 5.2 and 5.3, Nowrouzezahrai
// 2007 section 4.2).
#include "fit/models/regressor.h"

namespace penumbra {

// Chooses alpha by blocked cross-validation and sets the model's input PCA, weights, bias and ridge.
RegressionErrors trainLinear(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
