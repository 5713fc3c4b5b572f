#pragma once
// k-means: points in groups around centers, so that the squares of the distances to the centers add up to little.
#include <cstdint>
#include <span>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct PointGroups {
    std::vector<Vec3d> centers;                 // [k], the mean of each group
    std::vector<std::uint32_t> group_of_point;  // [N] < k
    double squares = 0;                         // sum of the squares of all distances to the own center
};

// Moves the centers to the means of the points that are nearest to them, until no point changes its group (or 100
// times). A center without points is dropped. There must be a point and a center.
PointGroups improveGroups(std::span<const Vec3d> points, std::vector<Vec3d> centers);

// Returns the best of `kGroupStarts` runs of improveGroups(), each from random points that are far from one another
// (k-means++, Arthur and Vassilvitskii 2007). There are fewer than `count` groups where there are fewer places. The
// result depends on the points, the count and the seed alone.
constexpr int kGroupStarts = 10;
PointGroups groupPoints(std::span<const Vec3d> points, int count, std::uint64_t seed);

}  // namespace penumbra
