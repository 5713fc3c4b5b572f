#include "runtime/evaluate/pose_features.h"

#include <algorithm>
#include <cassert>

namespace penumbra {

PoseFeatures::PoseFeatures(const AssetView& asset)
    : asset_(&asset),
      bones_(asset.animation.jointCount()),
      rotations_(bones_.size()),
      seen_(seesBones() ? 12 * (bones_.size() - 1) : asset.animation.pose_size),
      absolute_(bones_.size()) {
    for (const InputJointView& input : asset.model.input_joints) absolute_[std::size_t(input.joint)] = input.absolute();
}

void PoseFeatures::set(std::span<const Affine> bones, std::span<const float> pose) {
    assert(bones.size() == bones_.size() && (seesBones() || pose.size() == seen_.size()));
    std::copy(bones.begin(), bones.end(), bones_.begin());
    for (std::size_t j = 0; j < bones.size(); ++j) rotations_[j] = nearestRotation(bones[j].linear());
    if (!seesBones()) std::copy(pose.begin(), pose.end(), seen_.begin());
    joint_ = -1;
}

std::span<const float> PoseFeatures::of(int joint) {
    // Neighbouring clusters often share a joint, so its features are computed once for all of them.
    if (seesBones() && joint != joint_) lookFrom(std::size_t(joint));
    joint_ = joint;
    return seen_;
}

// Computes M_c^-1 M_j center_j - center_j in units of feature_scale and R_c^T R_j - I, for every joint j but c
// (model_file.h). From a bone that cannot be inverted (scaled to nothing) others are seen where its rotation alone
// would put them. A joint that stands for a number is seen as it is.
void PoseFeatures::lookFrom(std::size_t joint) {
    const Mat3 linear = bones_[joint].linear(), adjugate = transposed(cofactor(linear));
    const float determinant =
        dot(Vec3{linear.m[0], linear.m[1], linear.m[2]}, Vec3{adjugate.m[0], adjugate.m[3], adjugate.m[6]});
    const Mat3 to_rest = transposed(rotations_[joint]);
    const float scale = 1 / asset_->model.feature_scale;
    float* out = seen_.data();
    for (std::size_t j = 0; j < bones_.size(); ++j) {
        if (j == joint) continue;
        const Vec3 center = asset_->model.joint_centers[j];
        if (absolute_[j]) {
            const Vec3 moved = (bones_[j].point(center) - center) * scale;
            for (int i = 0; i < 3; ++i) *out++ = moved[i];
            out = std::fill_n(out, 9, 0.0f);
            continue;
        }
        const Vec3 offset = bones_[j].point(center) - bones_[joint].translation();
        const Vec3 seen = determinant != 0 ? (adjugate * offset) / determinant : to_rest * offset;
        const Vec3 moved = (seen - center) * scale;
        const Mat3 turned = to_rest * rotations_[j];
        for (int i = 0; i < 3; ++i) *out++ = moved[i];
        for (int i = 0; i < 9; ++i) *out++ = turned.m[i] - (i % 4 == 0 ? 1.0f : 0.0f);
    }
}

}  // namespace penumbra
