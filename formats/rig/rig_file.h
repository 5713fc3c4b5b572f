#pragma once
// Reads animated characters from glTF 2.0 (.glb, .gltf and .vrm, by tinygltf) and from FBX, Collada and DirectX .x (by
// assimp).
//
// Positions are those of the scene that the file shows, skinned as section 3.7.3 of glTF 2.0 asks: the node of a
// skinned mesh does not move it. Morph targets shape a mesh before its skin does (rig_morphs.h). FBX is turned and
// scaled by the axes and the unit that the file states. A .x file states neither and is only mirrored to right-handed.
//
// Joints are the nodes of all skins that are drawn. Then comes a joint for each node that moves a mesh without skin
// (its own node or that of an animated ancestor, under the nearest joint), then "scene" for meshes that stand still.
// A node that two skins use with different inverse bind matrices becomes two joints, "arm" and "arm#2". The exception
// is that one transform S takes the second mesh to the first one's space in all joints: then rest_positions of the
// second mesh are S x POSITION.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/surface.h"
#include "formats/rig/source_look.h"

namespace penumbra {

enum class Interpolation : std::uint8_t { kStep, kLinear, kCubicSpline };

// One animated property of one node. A key has 3 values (translation, scale) or 4 (rotation, quaternion x y z w).
// With kCubicSpline it has three times as many (in-tangent, value, out-tangent), as in glTF.
struct Channel {
    int node = 0;
    enum class Path : std::uint8_t { kTranslation, kRotation, kScale } path = Path::kTranslation;
    Interpolation interpolation = Interpolation::kLinear;
    std::vector<double> times;  // seconds, ascending, at least one; the value jumps where two are equal
    std::vector<float> values;
};

struct Clip {
    std::string name;  // unique in the rig; unnamed clips become "clip0", ...
    double duration = 0;
    std::vector<Channel> channels;
    int gltf_animation = -1;  // index in the rig's own .glb or .gltf; -1: the clip comes from another file
    double moved_by = 0;      // seconds that the times of the file were moved by
};

// Weights of the rig's morph targets over the time of a clip. Keys are as in Channel.
struct WeightCurve {
    int clip = 0;                        // indexes Rig::clips
    std::vector<std::uint32_t> weights;  // [count] which ones
    Interpolation interpolation = Interpolation::kLinear;
    std::vector<double> times;
    std::vector<float> values;  // [keys, count], or [keys, 3, count] with kCubicSpline
};

struct Node {
    std::string name;
    int parent = -1;  // index; parents come before children
    std::array<double, 3> translation{0, 0, 0};
    std::array<double, 4> rotation{0, 0, 0, 1};
    std::array<double, 3> scale{1, 1, 1};
    std::optional<std::array<double, 16>> matrix;  // column-major; a node with a matrix is not animated
};

// A picture that a material names: a PNG or JPEG file. The reader of the rig does not open it.
struct Texture {
    std::string name;            // the field that names it, for messages
    std::filesystem::path file;  // the file that has it; empty where `bytes` has it
    std::vector<std::byte> bytes;
};

// How a material stops light (glTF 2.0, section 3.9.4): all of it, where its alpha is at least the cut-off, or as much
// as alpha says.
enum class AlphaMode : std::uint8_t { kOpaque, kMask, kBlend };

// The colour of a material: linear Rec.709, as the file states it.
struct MaterialColor {
    std::optional<Vec3> base;                // unset: there is no material, or it tells none
    std::shared_ptr<const Texture> texture;  // multiplies `base`; null: none
    TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
    std::string problem;  // a whole message that says why the colour cannot be known; "" when it can
    AlphaMode alpha_mode = AlphaMode::kOpaque;
    float alpha_cutoff = 0.5f;  // for kMask
    float alpha = 1;            // alpha of the base colour; the texture and the vertices multiply it
    bool double_sided = false;
};

// A picture of a material beside that of its base colour, and where it lies.
struct PartTexture {
    TextureRole role = TextureRole::kNormal;
    std::shared_ptr<const Texture> texture;
    TextureWrap wrap_u = TextureWrap::kRepeat, wrap_v = TextureWrap::kRepeat;
    float strength = 1;                     // normals: factor on the part in the plane; occlusion: its strength
    std::vector<std::array<double, 2>> uv;  // [vertices] v points down
};

// The appearance of one part of the source: the product of base, texture and tint.
struct PartColor {
    MaterialColor material;
    std::vector<std::array<double, 2>> uv;  // [vertices] v points down; empty without texture
    std::vector<Vec3> tints;                // [vertices] linear; empty: white
    std::vector<float> alphas;              // [vertices]; empty: 1
    std::vector<PartTexture> textures;      // for other roles than kBaseColor, each at most once
    std::string textures_problem = "";      // a message that says why `textures` are not all; "" when they are
    std::vector<TangentTurn> turns = {};    // [vertices] of the normal map; empty: none
};

// Where a part stands in the .glb or .gltf that it comes from; -1: it comes from another file.
struct GltfPlace {
    int node = -1, primitive = -1;  // a node of the document, and a primitive of its mesh
    bool operator==(const GltfPlace&) const = default;
};

// A part in the rig. Its vertices stand together in Mesh::source_vertex.
struct ColoredPart {
    PartColor color;
    std::uint16_t slot = 0;
    std::size_t first_vertex = 0, vertices = 0;  // range of source_vertex
    std::vector<Triangle> triangles;             // indices into the part's vertices
    GltfPlace gltf = {};
    // Row-major 3x4, from the positions of the file to Mesh::rest_positions.
    std::array<double, 12> to_rest{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    SourceLook look = {};
};

// Something that a file says and its reader does not do, and what is seen of that.
struct RigNote {
    std::string file;
    std::string node;     // "" where it is not about one
    std::string feature;  // "KHR_materials_transmission"
    std::string effect;   // "the glass hides what is behind it"

    bool operator==(const RigNote&) const = default;
};
// Returns "FILE: node 'NODE': FEATURE: EFFECT".
std::string textOf(const RigNote& note);

struct Rig {
    Mesh mesh;
    std::vector<ColoredPart> part_colors;
    // [T] the source vertices that the corners of mesh.triangles come from, in the same order
    std::vector<Triangle> source_corners;
    Skin skin;
    std::vector<Vec3> rest_normals;  // [V], unit
    std::vector<Node> nodes;
    std::vector<int> node_of_joint;  // [J]
    // [J]: row-major 3x4 matrices that map from the space of rest_positions to the joint
    std::vector<std::array<double, 12>> inverse_bind;
    std::vector<Clip> clips;
    std::vector<WeightCurve> weight_curves;
    // The rig and every file that it refers to. Depfiles and provenance list them.
    std::vector<std::filesystem::path> files_read;
    std::vector<RigNote> notes;    // each once
    std::vector<std::string> log;  // how which reader read each file, for -v
    // The .glb that the first file was converted to. Only with RigOptions::keep_converted; null if it was not.
    std::shared_ptr<const std::vector<std::byte>> converted;
};

// Returns what the materials of the parts say and nobody shows, each once. Rig::notes has what bakes miss of it.
std::vector<RigNote> lookNotes(const Rig& rig);

// Tells for each vertex whether its bones mirror it at rest. Triangles are wound so that they face outwards at rest in
// the scene, and rest_normals point outwards in the space of rest_positions (normalMatrix() in sh/vec3.h turns them by
// the sign of the determinant). So where bones mirror, the two are opposite.
std::vector<bool> mirroredAtRest(const Rig& rig);

// The name of the clip that sampleFrames() gives a rig without clips.
constexpr const char* kRestClip = "rest";

// Returns the frames that `clips` (names; empty = all) have at `fps`, or at the union of the clip's own key times for
// fps 0 (keys closer than 1e-5 s count as one). A clip whose duration is 0 has one frame. A rig without clips has one
// frame of the rest pose in a clip called "rest". Throws UsageError for unknown clip names, and lists the known ones.
FrameList sampleFrames(const Rig& rig, const std::vector<std::string>& clips, double fps);

struct RigPose {
    std::vector<Affine> bones;  // [J] skinning matrices, model space
    // [3J] the rotation vector of each joint relative to its parent joint and to rest, log(q_rest^-1 q); q is the
    // node's own rotation, times those of the nodes between the two
    std::vector<float> pose;
    std::vector<float> weights;  // [M] of Mesh::morphs
};
// Poses the rig. `clip` indexes rig.clips; -1 is the rest pose (node transforms as they stand in the file). Times
// outside of the keys are clamped to these.
RigPose evaluatePose(const Rig& rig, int clip, double time);

}  // namespace penumbra
