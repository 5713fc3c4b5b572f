#pragma once
// The box of a character without what stands far from it: a floor of a kilometre, a dome of sky, a lost helper.
#include <cstdint>
#include <span>

#include "sh/bounding_box.h"

namespace penumbra {

// Returns the box of the triangles whose corners `corners` lists, three by three. Points that no triangle uses do not
// count. Triangles that reach much farther from the middle than most do not count either: with d = the weighted median
// of how far the triangles reach from the median of their corners, the box holds those that reach at most kKeptReach d,
// where any reaches farther than kFarReach d. The weight of a triangle is 1, or less where it is larger than most: 1 /
// longest edge, in units of the harmonic mean of all longest edges. Without triangles it is the box of all points.
BoundingBox characterBox(std::span<const std::uint32_t> corners, std::span<const Vec3> points);

constexpr double kFarReach = 32, kKeptReach = 8;

}  // namespace penumbra
