#pragma once
// How Nowrouzezahrai, Geiger, Mitchell, Sumner, Jarosz and Gross (ISMAR 2011, section 3.2) join a marker's frame with
// that of a tracker without markers, and the alternation that stands between it and fit/camera/align_tracks.h. Both are
// here for comparison.
#include <span>

#include "fit/camera/align_tracks.h"

namespace penumbra {

constexpr double kMinTwoViewDegrees = 15;

// The paper's closed form. R is R^_1^-1 R_1 with rotations from the world to the camera; with those from the camera to
// the world, as one may read the paper, the same formula is wrong. Then the rays from both cameras towards the marker
// meet in its origin:
//   t = (d1x (p^2y - p^1y) - d1y (p^2x - p^1x)) / (d1y d2x - d1x d2y), s = t |d2| / |p2|, o = p^2 + t d2.
// Throws InvalidInput where the views are less than kMinTwoViewDegrees apart as seen from the marker, and where the
// rays are parallel in x and y (both cameras at one azimuth): t is then noise.
FrameMap alignTwoViews(const PosePair& first, const PosePair& second);

// Least squares of sum |p^ - s R p - o|^2 / (s place_noise)^2 + sum |R^ R - R_a|_F^2 / turn_noise^2 by 20 alternations
// of s and R. Needs two views or more.
FrameMap alignByAlternation(std::span<const PosePair> pairs, double place_noise, double turn_noise);

}  // namespace penumbra
