#pragma once
// The far visibility of a model's vertices, for fits and predictions of composed models (docs/formulas.md, section 7).
#include <cstdint>
#include <span>
#include <vector>

#include "fit/clusters/pose_table.h"
#include "formats/stage/model_file.h"
#include "sh/far/far_tables.h"

namespace penumbra {

// What a composed model needs beside the pose. `composition` must fit the model: fields, parts of vertices and steps.
FarTables makeFarTables(const Composition& composition, const Convention& convention);

// Some vertices of a model, as a mesh of their own that can be skinned.
struct VertexSet {
    Mesh mesh;                             // without triangles
    std::vector<InputJoint> input_joints;  // of the model, whose last inputs are the weights of morph targets
    std::size_t inputs = 0;                // how many the model has
    Skin skin;
    std::vector<Vec3> rest_normals, rest_tangents;
    std::vector<std::uint16_t> part;   // [V of the set]
    std::vector<std::uint8_t> gains;   // [V of the set, Composition::near_count]
    std::vector<std::uint16_t> joint;  // [V of the set] the joint that carries the tangent
    std::vector<std::uint32_t> order;  // [V of the set] its vertices, those of one part together
    std::vector<std::uint32_t> id;     // [V of the set] their numbers in the model
};
VertexSet vertexSet(const Model& model, std::span<const std::uint32_t> vertices, std::span<const int> joint_of_cluster);

// A set of vertices in one pose.
struct PosedVertices {
    std::vector<Vec3> positions, normals;
};
PosedVertices skinned(const VertexSet& set, std::span<const Affine> bones);
// The same for a deforming mesh whose fronts are given, [Vs] each. A back has the opposite normal of its front.
PosedVertices deformed(const VertexSet& set, std::span<const Vec3> positions, std::span<const Vec3> normals);

// A set of vertices and the parts in one pose.
struct SetPose {
    PosedVertices vertices;
    std::span<const Affine> bones;
    std::span<const PosedPart> parts;
};
SetPose poseOfSet(const VertexSet& set, const PoseTable& poses, std::size_t frame, std::span<const PosedPart> parts);

// Writes the far visibility of every vertex of the set in one pose, [V of the set, kFarCoefficients] in the local
// frames, times that of its near parts.
void farFactors(const FarTables& tables, const VertexSet& set, const SetPose& pose, std::span<float> out);
// Writes the visibility of one other part alone. It is near_part[p] for vertices of part p; kNoPart hides nothing.
void nearFactor(const FarTables& tables, const VertexSet& set, const SetPose& pose,
                std::span<const std::uint16_t> near_part, std::span<float> out);

// Multiplies local numbers [V, n] in convention D by far factors [V, kFarCoefficients].
void multiplyByFar(const FarTables& tables, std::span<const float> far, std::span<float> coefficients);

}  // namespace penumbra
