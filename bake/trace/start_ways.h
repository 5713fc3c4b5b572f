#pragma once
// Finds the way from the points of a hard edge to where their rays start over a solid.
//
// Problem: at a hard edge several points stand at one place, each with the normal of its own side. In an inner edge a
// start along that normal lies in the plane of the other side, so that rays pass behind that side and see light that
// they should not see.
//
// Here: all points of a place start between the sides, along the sum of their normals. The hemisphere that a point
// measures stays that of its own normal.
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// Returns the unit way of each vertex [V]. `first` [Vs] is the first vertex of each place (firstOfPlaces()), `normals`
// [V] are the posed ones. A point leaves out normals that are nearly opposite to its own, which are the other side of
// a sheet, and takes its own normal where the sum is nearly in its own plane.
std::vector<Vec3> startWays(std::span<const std::uint32_t> first, std::span<const Vec3> normals);

}  // namespace penumbra
