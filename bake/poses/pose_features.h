#pragma once
// Tells how different two poses of a rig are for shadows. Root motion does not count, and near bones count most.
//
// For a bone i and another bone j, p_ij is the center of what j moves, seen from i (in i's rest space), in diagonals
// of the rest box. These are the relative positions that fit/models/features.h predicts from. The distance of two
// poses a and b is
//     d(a, b)^2 = sum_i s_i sum_j n_ij |p_ij(a) - p_ij(b)|^2,   n_ij = w_ij^2 / sum_j w_ij^2,
//     w_ij = 1 / (0.02 + d_ij^2)
// Here s_i is the share of the skin weights that bone i has, d_ij is the distance of the two centers over all frames
// (rms), and j runs over the 24 bones nearest to i. So d is the root of a weighted mean over the vertices of how far
// their neighbours moved. 0.02 and the form of w are those of fit/models/features.h, where cross-validation chose
// them.
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

constexpr double kMaxFeatureBytes = double(std::size_t(2) << 30);  // limit for the features of all poses together

// The bones that move vertices.
struct MovingBones {
    std::vector<std::size_t> joint;  // ascending
    std::vector<double> share;       // share of the skin weights; sums to 1
    std::vector<Vec3d> center;       // centre of the vertices that the joint moves, in the rest space
    double diagonal = 1;             // diagonal of the rest box
    std::size_t count() const { return joint.size(); }
};
MovingBones movingBones(const Rig& rig);

// One row for each frame. The Euclidean distance of two rows is d.
struct PoseFeatures {
    std::size_t frames = 0, width = 0;
    std::vector<float> values;  // [frames, width]
    std::span<const float> row(std::size_t f) const { return std::span(values).subspan(f * width, width); }
};

// Computes the features. They are the same for any number of threads. A rig with only one bone that moves vertices
// has width 0, so that all its poses look alike. Throws UsageError when the features would take more than 2 GiB.
PoseFeatures poseFeatures(const Rig& rig, std::span<const RigFrame> frames, int threads);

}  // namespace penumbra
