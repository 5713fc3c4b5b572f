#pragma once
// Describes how the triangles of a deforming mesh turn. Near-rigid parts are found from this.
#include "fit/clusters/rigid_parts.h"
#include "fit/numerics/matrix.h"

namespace penumbra {

// Returns a point for each triangle, [Ts, D]. The distance of two points is about the angle by which the rotations of
// their triangles differ, as a root mean square over the frames and in radians. This is exact for small angles, but for
// what PCA drops: usually at most 1% of the variance, more if 16 dimensions do not hold the rest.
MatrixF triangleMotions(const DeformingFrames& mesh, int threads);

// Returns at most `most` indices of `count` things, evenly spread and in ascending order. When there are no more than
// `most`, it returns all.
std::vector<std::size_t> evenlySpread(std::size_t count, std::size_t most);

}  // namespace penumbra
