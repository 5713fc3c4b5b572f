#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

// Computes f_i = integral of f(s) y_i(s) ds as the sum of weight * f * y_i. out.size() == coefficientCount(order),
// order <= kMaxProductOrder. Sums are made in double and in the order of the samples.
void project(int order, std::span<const WeightedDirection> samples, const std::function<double(Vec3d)>& f,
             std::span<double> out);

// Computes v_i = 4pi/N times the sum of y_i over the directions that are visible (visible[s] != 0), N =
// directions.size().
void projectVisibility(int order, std::span<const Vec3d> directions, std::span<const std::uint8_t> visible,
                       std::span<double> out);

}  // namespace penumbra
