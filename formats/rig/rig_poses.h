#pragma once
// Poses by the transforms of their nodes, and clips made of poses: key k, at k seconds, is pose k, with STEP
// interpolation, so that nothing lies between two poses.
#include <span>
#include <string>

#include "formats/rig/rig_file.h"
#include "formats/rig/rig_matrix.h"

namespace penumbra {

struct RigFrame {
    int clip = -1;  // indexes rig.clips; -1 = rest pose
    double time = 0;
};

// A node's transform to its parent: translation x rotation x scale. Where the node has a matrix, that one counts.
struct NodePose {
    std::array<double, 3> translation{};
    Quaternion rotation{0, 0, 0, 1};  // unit
    std::array<double, 3> scale{1, 1, 1};
};
// Returns the transforms of all nodes [N] in a frame.
std::vector<NodePose> nodePoses(const Rig& rig, RigFrame frame);
// Returns every node's transform to its parent, and to model space.
std::vector<Matrix> localTransforms(const std::vector<Node>& nodes, std::span<const NodePose> poses);
std::vector<Matrix> globalTransforms(const std::vector<Node>& nodes, std::span<const NodePose> poses);

// A node's pose as numbers: translation, quaternion x y z w, scale.
constexpr std::size_t kNodeValues = 10;
void appendValues(const NodePose& pose, std::vector<float>& out);
// Reads the poses of nodes [N] from N * kNodeValues numbers.
std::vector<NodePose> nodePosesOf(std::span<const float> values);

// Stores the node transforms of `frames` as float keys. Bones agree with those of the frames to float rounding.
Clip clipOfFrames(const Rig& rig, std::span<const RigFrame> frames, std::string name);

// Makes poses from rotation vectors of the joints, [M,3J] as in RigPose::pose. Every joint's node turns. Nodes that
// are no joint, translations and scales stay as in the rest pose. Joints of one node must agree, and the first
// counts. A node with a matrix cannot turn.
Clip clipOfRotations(const Rig& rig, std::span<const float> rotations, std::string name);

// Makes poses from the transforms of all nodes, [X, N, kNodeValues]. Nodes with a matrix keep it.
Clip clipOfNodes(const Rig& rig, std::span<const float> values, std::string name);

// Tells whether the joint can be turned and is the first of its node.
bool turnsItself(const Rig& rig, std::size_t joint);

// Writes the rig with all of its clips as a glTF binary that readRig() reads as the same rig: the same vertices in
// the same order, the same triangles, and joints and weights to float rounding. All meshes become one skinned mesh.
// `extras` (JSON) goes into the file's extras. Throws Unsupported when it would exceed the 4 GiB of a GLB.
void writeGlb(const std::filesystem::path& path, const Rig& rig, const std::string& extras);

}  // namespace penumbra
