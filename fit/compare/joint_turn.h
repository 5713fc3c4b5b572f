#pragma once
// Poses that no one baked: one joint turned about an axis, all else as in a baked frame.
#include <span>
#include <vector>

#include "fit/compare/compare_character.h"

namespace penumbra {

// Rotation of every joint relative to its parent, rest pose taken out, as axis times angle; zero for roots.
// [F, J]: log(R_parent^T R_joint), radians.
std::vector<Vec3d> relativeRotations(const PoseTable& poses, const std::vector<std::int32_t>& parents);

// The joint turned about a fixed axis, all else as in one baked frame.
struct JointTurn {
    int joint = 0;
    Vec3d axis;       // unit, in the parent's rest frame: the principal one of the training frames
    Vec3d pivot;      // in the parent's rest frame: what both bones move alike
    Vec3d pose_axis;  // change of the joint's three numbers of the pose vector a radian; zero: there are none
    std::size_t base_frame = 0;  // the training frame whose other joints are nearest to their means
    double base_angle = 0;       // of that frame, radians about `axis`
};
// Principal axis of a joint's relative rotations over the given frames.
Vec3d principalTurn(std::span<const Vec3d> rotations, std::size_t joints, std::size_t joint,
                    std::span<const std::size_t> frames);
JointTurn makeJointTurn(const CompareInput& input, const CompareCharacter& character, int joint);

struct TurnedPose {
    std::vector<Affine> bones;
    std::vector<float> pose;
};
TurnedPose poseAt(const CompareInput& input, const JointTurn& turn, double angle);

}  // namespace penumbra
