#pragma once
// What a cluster's numbers are predicted from. The recipe is written down in formats/model_file.h; the run-time
// evaluator repeats it.
#include <span>
#include <vector>

#include "fit/matrix.h"
#include "formats/model_file.h"

namespace penumbra {

// What rawFeatures needs beside the pose.
struct FeatureRecipe {
    FeatureKind kind = FeatureKind::kRelativeBones;
    double scale = 1;                 // box diagonal of the rest positions
    std::vector<Vec3> joint_centers;  // [J]
    std::size_t pose_size = 0;        // P

    std::size_t count() const;  // N: P, or 12 (J - 1)
};

// Weighted centroid of the rest positions that each joint moves; a joint that moves nothing gets its nearest
// ancestor's, or the centroid of the mesh.
std::vector<Vec3> jointCenters(const Mesh& mesh, const Skin& skin);

// out.size() == recipe.count(). `rotations` is nearestRotation of each bone's linear part, [J]. A cluster bone that
// cannot be inverted (|det| < 1e-9) counts as its rotation and translation alone.
void rawFeatures(const FeatureRecipe& recipe, int cluster_joint, std::span<const Affine> bones,
                 std::span<const Mat3> rotations, std::span<const float> pose, std::span<double> out);

// Factor of each raw feature before the input PCA, so that its variance says how much it should matter. Joint angles: 1
// (the paper's way). Relative bones: 1 / sqrt(0.02 + d^2) for the twelve numbers of a bone, d^2 = mean over `rows` of
// the squared distance between the bone's centre and the cluster's in box diagonals: near bones hide more of the sky.
std::vector<double> featureWeights(const FeatureRecipe& recipe, int cluster_joint, Vec3 cluster_center,
                                   const Matrix& raw, std::span<const std::size_t> rows);

}  // namespace penumbra
