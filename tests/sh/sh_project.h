#pragma once
// Projects functions and visibility on SH by sums over directions.
#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

#include "sh/quadrature.h"
#include "sh/sh_basis.h"

namespace penumbra {

// Computes f_i = integral of f(s) y_i(s) ds as the sum of weight * f * y_i. out.size() == coefficientCount(order),
// order <= kMaxProductOrder. Sums are made in double and in the order of the samples.
inline void project(int order, std::span<const WeightedDirection> samples, const std::function<double(Vec3d)>& f,
                    std::span<double> out) {
    assert(order >= 1 && order <= kMaxProductOrder && int(out.size()) == coefficientCount(order));
    std::array<double, coefficientCount(kMaxProductOrder)> storage;
    const std::span<double> basis = std::span(storage).first(out.size());
    std::fill(out.begin(), out.end(), 0.0);
    for (const WeightedDirection& sample : samples) {
        const double value = sample.weight * f(sample.direction);
        if (value == 0) continue;
        order <= kMaxOrder ? evalBasis(order, sample.direction, basis)
                           : evalBasisReference(order, sample.direction, basis);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += value * basis[i];
    }
}

// Computes v_i = 4pi/N times the sum of y_i over the directions that are visible (visible[s] != 0), N =
// directions.size().
inline void projectVisibility(int order, std::span<const Vec3d> directions, std::span<const std::uint8_t> visible,
                              std::span<double> out) {
    assert(order >= 1 && order <= kMaxOrder && int(out.size()) == coefficientCount(order));
    assert(directions.size() == visible.size() && !directions.empty());
    std::array<double, coefficientCount(kMaxOrder)> storage;
    const std::span<double> basis = std::span(storage).first(out.size());
    std::fill(out.begin(), out.end(), 0.0);
    for (std::size_t s = 0; s < directions.size(); ++s) {
        if (!visible[s]) continue;
        evalBasis(order, directions[s], basis);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] += basis[i];
    }
    const double weight = 4 * std::numbers::pi / double(directions.size());
    for (double& value : out) value *= weight;
}

}  // namespace penumbra
