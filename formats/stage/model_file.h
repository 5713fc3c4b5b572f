#pragma once
// x.model.h5: visibility as a function of the pose (HDF5, format "penumbra.model"; formats/README.md lists
// every dataset). docs/formulas.md, section 4, derives the models.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/drawn_mesh.h"
#include "formats/common/file_format.h"
#include "formats/common/mesh.h"
#include "formats/common/model_kind.h"
#include "formats/common/part_fields.h"
#include "formats/common/provenance.h"
#include "sh/far/near_parts.h"
#include "sh/indirect_coefficients.h"
#include "sh/visibility_convention.h"

namespace penumbra {

constexpr FileFormat kModelFormat{"penumbra.model", 1};

// The raw features of a cluster, in this order (fit/models/features.h computes them, and the run-time evaluator
// again):
// - kJointAngles: the frame's pose vector, P numbers.
// - kRelativeBones: 12 numbers for every joint j except the cluster's own joint c, in ascending order. The first 3
//   are the position of j's center in c's rest frame, M_c^-1 M_j center_j - center_j, divided by `feature_scale`. The
//   other 9 are the entries, row-major, of R_c^T R_j - I, R = nearestRotation(M.linear()). M are the frame's skinning
//   matrices. An absolute joint (InputJoint) does not know the cluster's motion: it has the position (M_j center_j -
//   center_j) / feature_scale, and 9 zeros.
// - kDihedrals: the frame's pose vector, P numbers: angles of a deforming mesh after PCA, then inputs (Model).
//
// These give the inputs x [I] of a cluster:
// - kLinear, kQuadratic, kNeural: x = input_basis (raw - feature_mean).
// - kAdditive: the inputs of one group after the other.
// Groups are what the cluster sees move. With kRelativeBones a group is a joint j != c with D = 13 inputs:
// boneInputs() (sh/pose_inputs.h) of its raw position + (center_j - center) / feature_scale, its rotation and
// joint_spreads[j]. An absolute joint has its raw position, then zeros. With kJointAngles a group is a joint with D =
// 3 inputs, its numbers of the pose. With kDihedrals it is a number of the pose, D = 1. Every model knows the ranges
// of the group inputs over training frames: out of range^2 = sum over g of group_weight_g |x_g - clamp(x_g)|^2,
// averaged over clusters by their vertices.
//
// Each input is clamped to its range over training frames, widened by kRangeMargin of it at both ends (ranges of
// groups are not widened), so that no pose can make the result explode. The units h [H] of a cluster are:
// - kLinear: x.
// - kQuadratic: x, then all products x_i x_j, i <= j, row by row.
// - kNeural: tanh(hidden_h . (x, 1)) (Nowrouzezahrai 2009 eq 12).
// - kAdditive: exp(-|x_g - hidden_h|^2 / 2), g = unit_group[h], where x_g are the inputs of that group.
// The scores are y = weights h + bias, and the numbers are mean + sum_k y_k basis_k. Last, each vertex' numbers move
// the shortest way to where its ambient visibility lies in [0, 1] (clampAmbient(), sh/visibility_convention.h).
struct ClusterModel {
    std::vector<std::uint32_t> vertices;      // [Vc], ascending
    int joint = 0;                            // the cluster's own joint
    Vec3 center;                              // mean rest position of its vertices
    std::vector<float> feature_mean;          // [N]; empty for kAdditive
    std::vector<float> input_basis;           // [I, N] row-major (rows: PCA directions); empty for kAdditive
    std::vector<float> input_min, input_max;  // [I], range of x over training frames; empty for kAdditive
    std::vector<std::uint32_t> groups;        // [G] ascending joints; kDihedrals: numbers of the pose
    std::vector<float> group_weight;          // [G], >= 0, its importance; 1 in sum with the groups that are not stored
    std::vector<float> group_min, group_max;  // [G, D], range of the group's inputs over training frames
    std::vector<float> hidden;                // kNeural: [H, I + 1]; kAdditive: [H, D], D inputs of a group
    std::vector<std::uint32_t> unit_group;    // kAdditive: [H], index into groups
    std::vector<float> weights;               // [K, H] row-major
    std::vector<float> bias;                  // [K]
    std::vector<float> mean;                  // [Vc, n], n = convention.size()
    std::vector<float> basis;                 // [K, Vc, n]
    double ridge = 0;                         // the prior's weight that cross-validation chose
    double train_error = 0,
           holdout_error = 0;  // sums of squares over variance, as relative error squared; holdout NaN if none

    std::size_t inputs() const { return feature_mean.empty() ? group_min.size() : input_min.size(); }
    std::size_t components() const { return bias.size(); }
    std::size_t units() const { return bias.empty() ? 0 : weights.size() / bias.size(); }
    // Counts the numbers of all arrays above except `vertices`: what a run-time needs of this cluster.
    std::size_t numberCount() const {
        return feature_mean.size() + input_basis.size() + input_min.size() + input_max.size() + groups.size() +
               group_weight.size() + group_min.size() + group_max.size() + hidden.size() + unit_group.size() +
               weights.size() + bias.size() + mean.size() + basis.size();
    }
};

struct ClipError {
    std::string clip;
    bool held_out = false;
    double relative_error = 0, rms_v = 0, ambient_error = 0;  // docs/formulas.md section 5
};

// A joint that moves no vertex but stands for inputs, which are numbers that are no part of the mesh (such as the
// center of a ball). Its bone is a translation (inputBone(), sh/rigid_fit.h).
struct InputJoint {
    std::uint32_t joint = 0;
    std::uint32_t column = 0;     // the first of its columns among the X inputs
    std::uint32_t columns = 3;    // 3: a point of the model frame; 1: any number
    float offset = 0, scale = 1;  // a number moves the joint by ((x - offset) scale, 0, 0); a point has 0 and 1

    bool absolute() const { return columns == 1; }
    bool operator==(const InputJoint&) const = default;
};

// What makes a model a composed one (docs/formulas.md, section 7). The clusters of such a model predict what a vertex
// sees past the nearby parts of the skeleton alone. The fields say how much the far parts block, for any pose. A
// vertex' numbers, in convention D, are
//   local x product over its far parts of their visibilities + residual,
// where near parts count as far ones with a gain each. The sum is moved to where its ambient visibility lies in [0, 1].
// farParts() (sh/far/far_visibility.h) lists the far parts of each part.
struct Composition {
    int local_steps = 2;
    bool floor = false;  // an infinite floor hides every direction with y < 0, for all vertices; it is no part
    PartFields fields;   // [P]
    std::vector<std::uint16_t> part_of_vertex;  // [V] < P
    std::vector<std::uint8_t> steps;            // [P, P] PartTable::steps
    // Near parts (sh/far/near_parts.h): parts that are not far, which the vertices of a part multiply in as if they
    // were, each with a gain of its own. The clusters then predict what such a vertex sees without them.
    std::size_t near_count = 0;             // at most kMaxNear; 0: the model has none
    std::vector<std::uint16_t> near_parts;  // [P, near_count], kNoPart where a part has fewer
    std::vector<std::uint8_t> near_gains;   // [V, near_count], times kPerGain
    // What the product leaves, as clusters of the same vertices and joints. Empty when that did not pay.
    std::vector<ClusterModel> residual;
    // Share of the energy that the residual takes from training frames which it also took in cross-validation, 0..1.
    // Its components count for so much where bytes are short.
    double residual_worth = 1;
};

// The light that reaches a vertex from other surfaces, as a function of the pose: kIndirectSize numbers
// (sh/indirect_coefficients.h) of the indirect transfer in the local frame, predicted as visibility is, but not
// clamped. The clusters have the vertices and joints of Model::clusters, and see all joints.
struct IndirectModel {
    int bounces = 3;
    ColorAxes axes;
    std::vector<ClusterModel> clusters;
    // rms of the error of the indirect transfer over rms of the direct transfer; that of held-out clips is NaN if none
    double train_share = 0, holdout_share = 0;
};

// A fitted model. A deforming mesh has no skeleton: its vertices are given in every frame. Its joints are near-rigid
// parts (influences = 1), whose bones are fitted to the vertices (partMotions(), sh/rigid_fit.h), then the input
// joints. Its normals are those of the front triangles (vertexNormals()).
struct Model {
    Mesh mesh;
    Skin skin;
    std::vector<Vec3> rest_normals;   // [V]
    std::optional<DrawnMesh> drawn;   // as VisibilityHeader::drawn: what an asset draws
    std::vector<Vec3> rest_tangents;  // [V], unit, orthogonal to rest_normals, carried by the cluster joint's rotation
    FrameList frames;                 // all frames of the visibility file, training and held out
    std::vector<Affine> bones;        // [F, J]
    int pose_size = 0;
    // [F, P]. For a deforming mesh with kDihedrals: pose_basis (angles - pose_mean), where the angles of its E edges
    // (sh/dihedral_angles.h) are turned to within pi of their means, then the X inputs; with kRelativeBones: only the
    // inputs.
    std::vector<float> pose;
    bool deforming = false;
    std::vector<Vec3> positions;           // [F, Vs] positions of the fronts; empty unless deforming
    std::vector<std::string> input_names;  // [X], the last numbers of the pose
    std::vector<InputJoint> input_joints;  // the last joints, ascending
    std::vector<float> pose_mean;          // [E], only for kDihedrals
    std::vector<float> pose_basis;         // [P - X, E]
    std::vector<std::string> holdout_clips;

    Convention convention;
    ModelKind kind = ModelKind::kLinear;
    FeatureKind features = FeatureKind::kRelativeBones;
    double feature_scale = 1;         // box diagonal of the rest positions
    std::vector<Vec3> joint_centers;  // [J], weighted centroid of the rest positions that j moves
    std::vector<Mat3> joint_spreads;  // [J], square root of their weighted second moments about it / feature_scale^2
    double input_variance = 0.9, output_variance = 0.95;
    std::vector<std::uint32_t> cluster_of_vertex;  // [V]
    std::vector<ClusterModel> clusters;
    std::optional<Composition> composition;
    std::optional<IndirectModel> indirect;
    std::vector<ClipError> clip_errors;
    Provenance provenance;
};

void writeModel(const std::filesystem::path& path, const Model& model);
Model readModel(const std::filesystem::path& path);  // throws IoError and InvalidInput

}  // namespace penumbra
