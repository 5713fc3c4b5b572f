#pragma once
// Plain structs that several kinds of files hold: mesh, skin, sampled animation.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/common/morph_targets.h"
#include "formats/common/opacity.h"
#include "sh/bounding_box.h"
#include "sh/vec3.h"

namespace penumbra {

using Triangle = std::array<std::uint32_t, 3>;

// The welded mesh of V shading points (vertices that share rest position and skin weights are one). The model frame
// is right-handed, with y up, in metres.
struct Mesh {
    std::vector<Triangle> triangles;           // [T], indices < V
    std::vector<Vec3> rest_positions;          // [V], in the space that bone matrices map from
    std::vector<std::uint32_t> source_vertex;  // [R], the shading point of each source vertex
    // The parts that may each have a material, "NODE/MATERIAL" of the source and unique, and the part of each vertex.
    // A vertex that welds several has the part of the first. Both empty: there is one part without a name.
    std::vector<std::string> slots;
    std::vector<std::uint16_t> slot_of_vertex;  // [V], < slots
    // True for a thin sheet: V = 2 Vs and T = 2 Ts. Vertex Vs + v is the back of v: it has the same position, the
    // negated normal, and the same slot and skin row. Triangle Ts + t is triangle t from behind: {a, b, c} becomes
    // {a, c, b}, each + Vs. source_vertex leads to fronts.
    bool two_sided = false;
    // Offsets that weights in the pose add to rest positions and rest normals before bones move them. Mostly empty.
    MorphTargets morphs;
    // Opacity of the triangles that do not stop all rays. It lists front triangles only.
    Opacity opacity;

    std::size_t vertexCount() const { return rest_positions.size(); }
    // Vs and Ts, the fronts, which come first. For a mesh that is not two-sided these are V and T.
    std::size_t frontVertexCount() const { return vertexCount() / (two_sided ? 2 : 1); }
    std::size_t frontTriangleCount() const { return triangles.size() / (two_sided ? 2 : 1); }
    // The triangles that rays can hit and that normals are computed from.
    std::span<const Triangle> frontTriangles() const { return std::span(triangles).first(frontTriangleCount()); }
};

struct Skin {
    std::vector<std::string> joint_names;  // [J], unique
    std::vector<std::int32_t> parents;     // [J], -1 for roots; parents[j] != j, no cycles
    int influences = 0;                    // K
    std::vector<std::uint16_t> joints;     // [V,K], < J; 0 where the weight is 0
    std::vector<float> weights;            // [V,K], >= 0, descending, each row sums to 1
    // At rest: joint to parent joint (for a root: to the scene), and rest positions to joint. Both are empty where a
    // file does not tell, or where a joint's scale is 0.
    std::vector<Affine> rest_transforms, inverse_bind;  // [J]

    std::size_t jointCount() const { return joint_names.size(); }
};

// The sampled frames of one or more clips, in order. --frames slices this list.
struct FrameList {
    std::vector<std::string> clip_names;  // [C], unique
    std::vector<std::uint16_t> clip;      // [F], index into clip_names, ascending
    std::vector<double> time;             // [F], seconds in the clip

    std::size_t frameCount() const { return time.size(); }
};

constexpr const char* kJointRotationVectors = "joint_rotation_vectors";
constexpr const char* kDihedralAngles = "dihedral_angles";

// Returns the diagonal of the axis-aligned box. 0 for an empty or
// one-point set.
double boxDiagonal(const std::vector<Vec3>& positions);
// Returns the box of the character alone (sh/character_box.h), and its diagonal.
BoundingBox characterBox(std::span<const Triangle> triangles, std::span<const Vec3> positions);
double characterDiagonal(std::span<const Triangle> triangles, std::span<const Vec3> positions);
double characterDiagonal(const Mesh& mesh);  // at rest

// Blends the bones of one vertex, of which a row of Skin::joints and Skin::weights tells.
Affine blendBones(std::span<const std::uint16_t> joints, std::span<const float> weights, std::span<const Affine> bones);

// Skins positions by linear blending, and normals by normalMatrix() of the blended linear part, normalised (a zero
// normal stays zero). `bones` has J skinning matrices (joint global x inverse bind). Bake, fit and the run-time
// evaluator all follow this very rule. Outputs are resized to V. The mesh has no morph targets (skinMorphed()).
void skinVertices(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& rest_normals,
                  const std::vector<Affine>& bones, std::vector<Vec3>& positions, std::vector<Vec3>& normals);

// Skins as skinVertices() the surface that morph weights [M] have shaped (restShape()). It is skinVertices() where the
// mesh has no targets. `pose` outlives the call.
struct SkinPose {
    const std::vector<Affine>& bones;
    std::span<const float> morph_weights;
};
void skinMorphed(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& rest_normals, const SkinPose& pose,
                 RestShape& out);

// Returns the weighted centroid of the rest positions that each joint moves. A joint that moves nothing gets that of
// its nearest ancestor, or the centroid of the mesh.
std::vector<Vec3> jointCenters(const Mesh& mesh, const Skin& skin);

// Returns area-weighted vertex normals of `positions`, all of unit length. A vertex without area gets a normal that
// points away from the centroid (or +y).
std::vector<Vec3> vertexNormals(std::span<const Triangle> triangles, std::span<const Vec3> positions);

// Returns the normals of a mesh at `positions` [V]: vertexNormals() of the fronts, and the opposite ones for backs.
// Bake, fit and the run-time evaluator all follow this very rule where there is no skin.
std::vector<Vec3> meshNormals(const Mesh& mesh, std::span<const Vec3> positions);

// Return a copy in which every vertex has a back. `mesh` is not two-sided yet.
Mesh withBacks(const Mesh& mesh);
Skin withBacks(const Skin& skin);
// Append the backs to the fronts: the same positions, and the opposite normals.
void appendBackPositions(std::vector<Vec3>& positions);
void appendBackNormals(std::vector<Vec3>& normals);

}  // namespace penumbra
