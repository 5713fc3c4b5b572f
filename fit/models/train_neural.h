#pragma once
// Trains the neural model: input PCA and a tanh net (Nowrouzezahrai 2009 eq 12 and 13).
#include "fit/models/regressor.h"

namespace penumbra {

// Chooses the number of neurons and the prior by cross-validation and sets the model's input PCA, hidden, weights, bias
// and ridge. There is no closed form of the leave-one-out error, so it is NaN.
RegressionErrors trainNeural(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
