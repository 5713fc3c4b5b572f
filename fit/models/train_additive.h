#pragma once
// Sums of radial units that each see one group's inputs: occlusion nearly adds up over occluders, so a model that never
// looks at two bones at once generalises to combinations of poses that it never saw.
#include "fit/models/regressor.h"

namespace penumbra {

RegressionErrors trainAdditive(const RegressionProblem& problem, ClusterModel& model);

}  // namespace penumbra
