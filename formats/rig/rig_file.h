#pragma once
// Animated characters from glTF 2.0 (.glb, .gltf through tinygltf), FBX, Collada and DirectX .x (through assimp).
//
// Positions are those of the scene that the file shows, skinned as glTF 2.0 section 3.7.3 has it: the node of a skinned
// mesh does not move it. Morph targets are ignored, default weights included. FBX is turned and scaled by the axes and
// the unit that it states; .x states neither and is only mirrored to right-handed. Joints are the nodes of all skins
// that are drawn, then one for each node that moves a mesh without skin (its own or that of an animated ancestor, under
// the nearest joint), then "scene" for meshes that stand still. A node that two skins use with different inverse bind
// matrices is two joints, "arm" and "arm#2", unless one transform S takes the second mesh to the first one's space in
// all joints: then rest_positions of the second mesh are S x POSITION.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

enum class Interpolation : std::uint8_t { kStep, kLinear, kCubicSpline };

// One animated property of one node. Values: 3 a key (translation, scale) or 4 (rotation, quaternion x y z w); with
// kCubicSpline three times as many (in-tangent, value, out-tangent), as glTF has it.
struct Channel {
    int node = 0;
    enum class Path : std::uint8_t { kTranslation, kRotation, kScale } path = Path::kTranslation;
    Interpolation interpolation = Interpolation::kLinear;
    std::vector<double> times;  // seconds, strictly ascending, at least one
    std::vector<float> values;
};

struct Clip {
    std::string name;  // unique in the rig; unnamed clips become "clip0", ...
    double duration = 0;
    std::vector<Channel> channels;
};

struct Node {
    std::string name;
    int parent = -1;  // parents come before children
    std::array<double, 3> translation{0, 0, 0};
    std::array<double, 4> rotation{0, 0, 0, 1};
    std::array<double, 3> scale{1, 1, 1};
    std::optional<std::array<double, 16>> matrix;  // column-major; then not animated
};

struct Rig {
    Mesh mesh;
    Skin skin;
    std::vector<Vec3> rest_normals;  // [V], unit
    std::vector<Node> nodes;
    std::vector<int> node_of_joint;                    // [J]
    std::vector<std::array<double, 12>> inverse_bind;  // [J], row-major 3x4: from rest_positions' space to the joint
    std::vector<Clip> clips;
    std::vector<std::filesystem::path> files_read;  // the rig and everything it refers to, for depfiles and provenance
};

// Reads several files as one rig: the first brings mesh and skin, later ones may bring clips only (joints matched by
// name). Checks everything; InvalidInput names file and node, Unsupported a required extension that we do not have.
// Zero-area triangles are dropped; a mesh without triangles, missing weights, NaN or a one-vertex mesh are errors.
Rig readRig(const std::vector<std::filesystem::path>& paths);

// The clip that sampleFrames() gives a rig without clips.
constexpr const char* kRestClip = "rest";

// The frames that `clips` (names; empty = all) have at `fps` (0: the union of the clip's own key times; keys closer
// than 1e-5 s are one). A clip whose duration is 0 has one frame. Unknown clip names: UsageError that lists the known
// ones. No clips at all: one frame of the rest pose in a clip called "rest".
FrameList sampleFrames(const Rig& rig, const std::vector<std::string>& clips, double fps);

struct RigPose {
    std::vector<Affine> bones;  // [J] skinning matrices, model space
    std::vector<float> pose;    // [3J] rotation vector of each joint relative to its parent joint and to rest,
                                // log(q_rest^-1 q); q is the node's own rotation, times those of nodes between the two
};
// `clip` indexes rig.clips, -1 = rest pose (node transforms as they stand in the file). Times outside clamp to the
// keys.
RigPose evaluatePose(const Rig& rig, int clip, double time);

}  // namespace penumbra
