#pragma once
#include <numbers>

namespace penumbra {

// One degree in radians. x * kDegree and radians(x) may differ in the last bit, and so may results that follow from
// them.
constexpr double kDegree = std::numbers::pi / 180;

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }
constexpr double degrees(double radians) { return radians * (180 / std::numbers::pi); }

}  // namespace penumbra
