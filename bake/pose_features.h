#pragma once
// How different two poses of a rig are for shadows: root motion does not count, near bones count most.
//
// For a bone i and another bone j, p_ij is the centre of what j moves, seen from i (in i's rest space), in diagonals of
// the rest box: the relative positions that fit/models/features.h predicts from. The distance of two poses a and b is
//     d(a, b)^2 = sum_i s_i sum_j n_ij |p_ij(a) - p_ij(b)|^2,   n_ij = w_ij^2 / sum_j w_ij^2,
//     w_ij = 1 / (0.02 + d_ij^2)
// with s_i the share of the skin weights that bone i has, d_ij the distance of the two centres over all frames (rms),
// and j the 24 bones nearest to i: the root of a weighted mean over the vertices of how far their neighbours moved.
// 0.02 and the form of w are those of fit/models/features.h, where they were chosen by cross-validation.
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

// Rows whose Euclidean distance is d.
struct PoseFeatures {
    std::size_t frames = 0, width = 0;
    std::vector<float> values;  // [frames, width]
    std::span<const float> row(std::size_t f) const { return std::span(values).subspan(f * width, width); }
};

// UsageError when they would take more than 2 GiB. The same numbers for any number of threads. A rig with one bone that
// moves vertices has width 0: all its poses look alike.
PoseFeatures poseFeatures(const Rig& rig, std::span<const RigFrame> frames, int threads);

}  // namespace penumbra
