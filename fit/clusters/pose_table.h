#pragma once
// Reads the poses of a visibility file as models see them: the bones and the pose of every frame.
#include <span>
#include <vector>

#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// The pose of every frame and what follows from it. F counts frames, J joints, P the numbers of a pose, X inputs, E
// edges, Vs front vertices.
struct PoseTable {
    std::size_t joints = 0, pose_size = 0;
    std::vector<Affine> bones;    // [F, J]
    std::vector<Mat3> rotations;  // [F, J] nearestRotation() of the bones' linear parts
    std::vector<float> pose;      // [F, P]; a deforming mesh has Model::pose of kDihedrals, or only the inputs

    Skin skin;                             // the file's skin or near-rigid parts, then the input joints
    std::vector<Vec3> joint_centers;       // [J]; a point is where it rests, in the first training frame
    std::vector<InputJoint> input_joints;  // they are the last joints
    bool deforming = false;
    std::vector<Vec3> positions, normals;      // [F, Vs] of the fronts; empty unless deforming
    std::vector<float> pose_mean, pose_basis;  // [E] and [P - X, E], where angles are asked for

    std::size_t frameCount() const { return joints ? bones.size() / joints : 0; }
    std::span<const Affine> bonesOf(std::size_t f) const { return std::span(bones).subspan(f * joints, joints); }
    std::span<const Mat3> rotationsOf(std::size_t f) const { return std::span(rotations).subspan(f * joints, joints); }
    std::span<const float> poseOf(std::size_t f) const { return std::span(pose).subspan(f * pose_size, pose_size); }
};

// Returns nearestRotation() of each bone's linear part.
std::vector<Mat3> rotationsOf(std::span<const Affine> bones);

struct PoseRequest {
    std::vector<std::size_t> train = {};  // frames that parts, ranges of inputs and angles come from; empty means all
    std::size_t parts = 0;                // number of parts of a deforming mesh; 0 lets findRigidParts() choose
    double angle_variance = 0;  // share of the variance that the PCA of the dihedral angles keeps; 0 means no angles
    int threads = 0;
};
PoseTable readPoses(const VisibilityReader& reader, const PoseRequest& request);

}  // namespace penumbra
