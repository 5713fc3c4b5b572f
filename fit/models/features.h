#pragma once
// What a cluster's numbers are predicted from. The recipe is written down in formats/stage/model_file.h; the run-time
// evaluator repeats it.
#include <span>
#include <vector>

#include "fit/numerics/matrix.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// What rawFeatures needs beside the pose.
struct FeatureRecipe {
    FeatureKind kind = FeatureKind::kRelativeBones;
    double scale = 1;                 // box diagonal of the rest positions
    std::vector<Vec3> joint_centers;  // [J]
    std::vector<Mat3> joint_spreads;  // [J]
    std::size_t pose_size = 0;        // P
    bool deforming = false;
    std::vector<InputJoint> input_joints = {};  // the last joints
    std::size_t input_count = 0;                // X, the last numbers of the pose

    std::size_t count() const;   // N: P, or 12 (J - 1)
    std::size_t groups() const;  // what a cluster may see: joints, P / 3 or J (its own never counts), or P numbers
    bool absolute(std::size_t joint) const;
};
FeatureRecipe recipeOf(const Model& model);

// Symmetric square root of the weighted mean of (p - centre)(p - centre)^T / scale^2 over the rest positions p that
// each joint moves; zero for a joint that moves nothing.
std::vector<Mat3> jointSpreads(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& centers, double scale);

// out.size() == recipe.count(). `rotations` is nearestRotation of each bone's linear part, [J]. A cluster bone that
// cannot be inverted (|det| < 1e-9) counts as its rotation and translation alone.
void rawFeatures(const FeatureRecipe& recipe, int cluster_joint, std::span<const Affine> bones,
                 std::span<const Mat3> rotations, std::span<const float> pose, std::span<double> out);

// Where a cluster is.
struct ClusterPlace {
    int joint = 0;
    Vec3 center;  // rest pose
};

// Factor of each raw feature before the input PCA, so that its variance says how much it should matter. Joint angles: 1
// (the paper's way). Relative bones: 1 / (0.02 + d^2) for the position of a bone, 0.3 times that for its rotation; d^2
// = mean over `rows` of the squared distance of its centre from the cluster's, in box diagonals: near bones hide more
// of the sky. Chosen by blocked cross-validation over the training clips of a 13,380-vertex character (199 frames,
// inputs at 90% / 99%): relative error 0.716 / 0.704, with weights 1 0.759 / 0.745, with the square root of these 0.729
// / 0.717; within 0.005 of that for exponents 2 to 3, 0.01 to 0.02 and rotations at 0.15 to 1.
std::vector<double> featureWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                   std::span<const std::size_t> rows);

// The inputs of one group (model_file.h), out.size() == groupInputs(recipe.kind); `raw` from rawFeatures().
void readGroup(const FeatureRecipe& recipe, const ClusterPlace& place, std::size_t group, std::span<const double> raw,
               std::span<double> out);

// How much each group matters, [recipe.groups()], sum 1. Relative bones: in proportion to 1 / (0.02 + d^2)^2, d as in
// featureWeights(), 0 for the cluster's own joint. Angles: all the same. With the inputs of boneInputs(), blocked
// cross-validation over the training clips of that character gives 0.520, 0.511, 0.502, 0.500 for exponents 0.5, 1, 2,
// 2.5 (an additive kernel of unit width, one prior for all components). The parts of a deforming mesh take the exponent
// 1: on a curtain of 64 square parts it gives 0.728, 2 gives 0.736 and 3 gives 0.766 (36 parts: 0.738, 0.728 and 0.730
// for 0.5, 1 and 2). Inputs weigh three times as much: 0.693, 0.686 and 0.698 for 1, 3 and 10 with half of the regions.
std::vector<double> groupWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                 std::span<const std::size_t> rows);

}  // namespace penumbra
