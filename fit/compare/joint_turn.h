#pragma once
// Makes poses that no one baked: one joint turns about an axis, and all else stays as in a baked frame.
#include <span>
#include <vector>

#include "fit/compare/compare_character.h"

namespace penumbra {

// Returns the rotation of every joint relative to its parent, without that of the rest pose, as axis times angle in
// radians: log(R_parent^T R_joint), [F, J]. It is zero for roots.
std::vector<Vec3d> relativeRotations(const PoseTable& poses, const std::vector<std::int32_t>& parents);

// A turn of one joint about a fixed axis while all else stays as in one baked frame.
struct JointTurn {
    int joint = 0;
    Vec3d axis;       // unit vector in the parent's rest frame, the principal axis over the training frames
    Vec3d pivot;      // point in the parent's rest frame that both bones move alike
    Vec3d pose_axis;  // change of the joint's three numbers of the pose vector for a radian; zero when there are none
    std::size_t base_frame = 0;  // the training frame whose other joints are nearest to their means
    double base_angle = 0;       // angle of that frame about `axis`, radians
};
// Returns the principal axis of a joint's relative rotations over the given frames.
Vec3d principalTurn(std::span<const Vec3d> rotations, std::size_t joints, std::size_t joint,
                    std::span<const std::size_t> frames);
JointTurn makeJointTurn(const CompareInput& input, const CompareCharacter& character, int joint);

struct TurnedPose {
    std::vector<Affine> bones;
    std::vector<float> pose;
};
TurnedPose poseAt(const CompareInput& input, const JointTurn& turn, double angle);

}  // namespace penumbra
