#pragma once
// Minimises a function of unit vectors by BFGS.
#include <functional>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Returns the value at unit `directions` and fills its gradient: one vector for each direction, orthogonal to it.
using DirectionObjective = std::function<double(std::span<const Vec3d> directions, std::span<Vec3d> gradient)>;

struct DirectionMinimum {
    std::vector<Vec3d> directions;
    double value = 0;
};

// Minimises the objective from `start` with Ceres' BFGS. The variables are coordinates in the tangent planes of the
// start, so no pole is singular. The search begins again in new tangent planes until the value changes by less than
// 1e-10 of itself, three times at most. Values should be of order 1.
DirectionMinimum minimiseOverDirections(const DirectionObjective& objective, std::span<const Vec3d> start);

}  // namespace penumbra
