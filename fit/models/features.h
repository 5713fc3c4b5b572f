#pragma once
// Computes the inputs from which a cluster's numbers are predicted. formats/stage/model_file.h writes down the recipe,
// and the run-time evaluator follows it too.
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// Everything that rawFeatures() needs besides the pose. J counts joints, P the numbers of a pose, N the raw features.
struct FeatureRecipe {
    FeatureKind kind = FeatureKind::kRelativeBones;
    double scale = 1;                 // box diagonal of the rest positions
    std::vector<Vec3> joint_centers;  // [J] rest positions
    std::vector<Mat3> joint_spreads;  // [J] jointSpreads()
    std::size_t pose_size = 0;        // P
    bool deforming = false;
    std::vector<InputJoint> input_joints = {};  // they stand for inputs and are the last joints
    std::size_t input_count = 0;                // X, inputs that are the last numbers of the pose
    // [J] the joints whose poses a cluster may read, with relative bones. Empty: all of them.
    std::vector<bool> seen = {};

    std::size_t count() const;   // N: P, or 12 (J - 1) for relative bones
    std::size_t groups() const;  // number of groups: J joints, P / 3 rotation vectors, or P numbers
    bool sees(std::size_t joint) const { return seen.empty() || seen[joint]; }
    // True when the joint stands for an input that every cluster sees as it is.
    bool absolute(std::size_t joint) const;
};
FeatureRecipe recipeOf(const Model& model);

// Returns, for each joint, the symmetric square root of the weighted mean of (p - center)(p - center)^T / scale^2 over
// the rest positions p that the joint moves. It is zero for a joint that moves nothing.
std::vector<Mat3> jointSpreads(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& centers, double scale);

// Computes the raw features of one pose for the clusters of `cluster_joint`; out.size() == recipe.count(). `rotations`
// [J] holds nearestRotation() of each bone's linear part. When the cluster's bone cannot be inverted (|det| < 1e-9),
// its rotation stands in for its linear part.
void rawFeatures(const FeatureRecipe& recipe, int cluster_joint, std::span<const Affine> bones,
                 std::span<const Mat3> rotations, std::span<const float> pose, std::span<double> out);

// The place of a cluster: its joint and its center.
struct ClusterPlace {
    int joint = 0;
    Vec3 center;  // mean rest position of its vertices
};

// Returns a factor for each raw feature. It is applied before the input PCA, so that a feature's variance says how much
// it should matter.
//
// - Joint angles have the factor 1, as in the paper.
// - Relative bones: the position of a bone has 1 / (0.02 + d^2) and its rotation 0.3 times that. d^2 is the mean over
//   `rows` of the squared distance of the bone's center from the cluster's, in box diagonals. Near bones hide more of
//   the sky.
//   Joints that the recipe does not see have 0.
// - Reduced dihedral angles have the factor 1, and inputs are scaled to a variance of 1.
//
// The weights of relative bones were chosen by blocked cross-validation over the training clips of a character with
// 13,380 vertices (199 frames, inputs at 90% / 99% of the variance). The relative error is 0.716 / 0.704. It is 0.759 /
// 0.745 with all weights 1 and 0.729 / 0.717 with the square roots of these weights. It stays within 0.005 of the best
// for exponents 2 to 3, for 0.01 instead of 0.02, and for rotations at 0.15 to 1.
std::vector<double> featureWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                   std::span<const std::size_t> rows);

// Writes the inputs of one group (model_file.h) into `out`; out.size() == groupInputs(recipe.kind). `raw` comes from
// rawFeatures().
void readGroup(const FeatureRecipe& recipe, const ClusterPlace& place, std::size_t group, std::span<const double> raw,
               std::span<double> out);

// Returns how much each group matters, [recipe.groups()], with the sum 1.
//
// - Relative bones: in proportion to 1 / (0.02 + d^2)^2 with d^2 as in featureWeights(), and 0 for the cluster's own
//   joint and for joints that the recipe does not see. Where no joint is seen all are 0. Parts of a deforming mesh have
//   the exponent 1 instead of 2, and inputs weigh three times as much.
// - Angles: all groups weigh the same.
//
// The figures below are relative errors in blocked cross-validation. On the training clips of the character above, with
// an additive kernel of unit width and one prior for all components, the exponents 0.5, 1, 2 and 2.5 give 0.520, 0.511,
// 0.502 and 0.500. On a curtain of 64 square parts the exponents 1, 2 and 3 give 0.728, 0.736 and 0.766; on one of 36
// parts 0.5, 1 and 2 give 0.738, 0.728 and 0.730. Inputs that weigh 1, 3 and 10 times as much give 0.693, 0.686 and
// 0.698 with half of the regions.
std::vector<double> groupWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                 std::span<const std::size_t> rows);

}  // namespace penumbra
