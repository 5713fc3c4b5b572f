#pragma once
// BFGS over unit vectors.
#include <functional>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// The value at unit `directions`, and its gradient there: one vector a direction, orthogonal to it.
using DirectionObjective = std::function<double(std::span<const Vec3d> directions, std::span<Vec3d> gradient)>;

struct DirectionMinimum {
    std::vector<Vec3d> directions;
    double value = 0;
};

// Ceres' BFGS in the tangent planes of `start` (no pole is singular), in new tangent planes until the value stays
// within 1e-10 of itself, three times at most. Values are of order 1.
DirectionMinimum minimiseOverDirections(const DirectionObjective& objective, std::span<const Vec3d> start);

}  // namespace penumbra
