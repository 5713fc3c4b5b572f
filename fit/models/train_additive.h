#pragma once
// Trains the additive model: a sum of radial units, each of which sees the inputs of one group (one bone, for example).
// Occlusion nearly adds up over occluders. A model that never looks at two bones at once is therefore also right for
// combinations of poses that it never saw.
#include "fit/models/regressor.h"

namespace penumbra {

// Sets unit_group, hidden (the units' centres), weights, bias and ridge of `model` from the training rows of `problem`.
// The groups of `model`, their weights and ranges must be set before (setGroups()). Groups that turn out to be of no
// use are removed. There is no closed form of the leave-one-out error, so it is NaN.
RegressionErrors trainAdditive(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
