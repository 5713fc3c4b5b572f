#pragma once
// Finds the vertex and the joint of a bake that best show how visibility changes as one joint turns (Nowrouzezahrai
// 2009, figure 6), and makes the poses of that turn, which no one baked: all else stays as in a baked frame.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_character.h"
#include "formats/stage/model_file.h"

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

// The data of figure 6.
struct JointSweep {
    std::uint32_t vertex = 0;
    std::string joint_name;
    JointTurn turn;
    std::vector<double> baked_angles, baked_ambient;  // [F] radians; [F] E of the vertex
    std::vector<bool> baked_held_out;                 // [F]
    double explained = 0;        // share of the variance of E over training frames that the angle explains
    std::vector<double> angles;  // radians, the points of the curves
};
// Chooses among up to 1500 vertices and all joints. It takes the pair with the largest (variance of E that a step
// function of the angle explains)^2 / variance of E. It returns nothing when no joint turns, or when the mesh has no
// skeleton.
std::optional<JointSweep> findJointSweep(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options);

// Returns E of the vertex at each of sweep.angles, as `model` predicts it.
std::vector<double> sweepAmbient(const CompareInput& input, const JointSweep& sweep, const Model& model);

}  // namespace penumbra
