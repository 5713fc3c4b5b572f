#pragma once
// Plain structs for what several files hold: mesh, skin, sampled animation.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

using Triangle = std::array<std::uint32_t, 3>;

// The welded mesh: V shading points (same rest position, same skin weights). Model frame: right-handed, y up, metres.
struct Mesh {
    std::vector<Triangle> triangles;           // [T], indices < V
    std::vector<Vec3> rest_positions;          // [V], in the space that bone matrices map from
    std::vector<std::uint32_t> source_vertex;  // [R], the shading point of each source vertex
    // The parts that may have a material each, "NODE/MATERIAL" of the source, unique; and the part of each vertex: of
    // one that welds several, the first. Both empty: one part without a name.
    std::vector<std::string> slots;
    std::vector<std::uint16_t> slot_of_vertex;  // [V], < slots
    // A thin sheet: V = 2 Vs and T = 2 Ts. Vertex Vs + v is the back of v: same position, normal negated, same slot and
    // skin row. Triangle Ts + t is triangle t from behind: {a, b, c} gives {a, c, b}, each + Vs. source_vertex leads to
    // fronts.
    bool two_sided = false;

    std::size_t vertexCount() const { return rest_positions.size(); }
    // Vs and Ts, which come first; V and T of any other mesh.
    std::size_t frontVertexCount() const { return vertexCount() / (two_sided ? 2 : 1); }
    std::size_t frontTriangleCount() const { return triangles.size() / (two_sided ? 2 : 1); }
    // What is traced, and what normals are computed from.
    std::span<const Triangle> frontTriangles() const { return std::span(triangles).first(frontTriangleCount()); }
};

struct Skin {
    std::vector<std::string> joint_names;  // [J], unique
    std::vector<std::int32_t> parents;     // [J], -1 for roots; parents[j] != j, no cycles
    int influences = 0;                    // K
    std::vector<std::uint16_t> joints;     // [V,K], < J; 0 where the weight is 0
    std::vector<float> weights;            // [V,K], >= 0, descending, each row sums to 1
    // At rest: joint to parent joint (of a root: to the scene); and rest positions to joint. Both empty where a file
    // does not say, or where a joint's scale is 0.
    std::vector<Affine> rest_transforms, inverse_bind;  // [J]

    std::size_t jointCount() const { return joint_names.size(); }
};

// Sampled frames of one or more clips, in order: the list that --frames slices.
struct FrameList {
    std::vector<std::string> clip_names;  // [C], unique
    std::vector<std::uint16_t> clip;      // [F], index into clip_names, ascending
    std::vector<double> time;             // [F], seconds in the clip

    std::size_t frameCount() const { return time.size(); }
};

constexpr const char* kJointRotationVectors = "joint_rotation_vectors";
constexpr const char* kDihedralAngles = "dihedral_angles";

// Diagonal of the axis-aligned box; the unit of every scale-relative tolerance. 0 for an empty or one-point set.
double boxDiagonal(const std::vector<Vec3>& positions);

// Linear blend skinning of positions; normals by the cofactor of the blended linear part, normalised (a zero normal
// stays zero). `bones` has J skinning matrices (joint global x inverse bind). This very rule is what bake, fit and the
// run-time evaluator agree on. Outputs are resized to V.
void skinVertices(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& rest_normals,
                  const std::vector<Affine>& bones, std::vector<Vec3>& positions, std::vector<Vec3>& normals);

// Weighted centroid of the rest positions that each joint moves; a joint that moves nothing gets its nearest
// ancestor's, or the centroid of the mesh.
std::vector<Vec3> jointCenters(const Mesh& mesh, const Skin& skin);

// Area-weighted vertex normals of `positions`; a vertex without area gets a unit normal that points away from the
// centroid (or +y). Every result is unit.
std::vector<Vec3> vertexNormals(std::span<const Triangle> triangles, std::span<const Vec3> positions);

// Of a mesh at `positions` [V]: vertexNormals() of the fronts; backs have the opposite ones. This very rule is what
// bake, fit and the run-time evaluator agree on where there is no skin.
std::vector<Vec3> meshNormals(const Mesh& mesh, std::span<const Vec3> positions);

// The same mesh with a back to every vertex. `mesh` is not two-sided yet.
Mesh withBacks(const Mesh& mesh);
Skin withBacks(const Skin& skin);
// Adds what the backs have to what the fronts have: the same positions, the opposite normals.
void appendBackPositions(std::vector<Vec3>& positions);
void appendBackNormals(std::vector<Vec3>& normals);

}  // namespace penumbra
