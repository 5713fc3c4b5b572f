#pragma once
// How the triangles of a deforming mesh turn: what near-rigid parts are found by.
#include "fit/clusters/rigid_parts.h"
#include "fit/numerics/matrix.h"

namespace penumbra {

// A point a triangle, [Ts, D]: the distance of two is about the root mean square over the frames of the angle, in
// radians, by which their rotations differ (exact for small angles, but for what PCA drops: at most 1% of the
// variance).
MatrixF triangleMotions(const DeformingFrames& mesh, int threads);

// Rows of `count` things, evenly spread, in ascending order: all of them where there are no more than `most`.
std::vector<std::size_t> evenlySpread(std::size_t count, std::size_t most);

}  // namespace penumbra
