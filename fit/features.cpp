#include "fit/features.h"

#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

constexpr double kSingular = 1e-9;
constexpr double kNearness = 0.02;  // box diagonals squared: keeps the weight of the nearest bones finite
constexpr double kRotationWeight = 0.3;

Mat3d toDouble(const Mat3& a) {
    Mat3d out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = a.m[i];
    return out;
}

Mat3d inverseLinear(const Affine& bone, const Mat3& rotation) {
    const Mat3d a = toDouble(bone.linear()), c = cofactor(a);
    const double det = a.m[0] * c.m[0] + a.m[1] * c.m[1] + a.m[2] * c.m[2];
    if (std::abs(det) < kSingular) return transposed(toDouble(rotation));
    Mat3d inverse = transposed(c);
    for (double& x : inverse.m) x /= det;
    return inverse;
}

Vec3d applyAffine(const Affine& bone, Vec3d p) { return toDouble(bone.linear()) * p + toDouble(bone.translation()); }

}  // namespace

std::size_t FeatureRecipe::count() const {
    return kind == FeatureKind::kJointAngles ? pose_size : 12 * (joint_centers.size() - 1);
}

void rawFeatures(const FeatureRecipe& recipe, int cluster_joint, std::span<const Affine> bones,
                 std::span<const Mat3> rotations, std::span<const float> pose, std::span<double> out) {
    assert(out.size() == recipe.count());
    if (recipe.kind == FeatureKind::kJointAngles) {
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = pose[i];
        return;
    }
    const auto own = std::size_t(cluster_joint);
    const Mat3d to_cluster = inverseLinear(bones[own], rotations[own]);
    const Mat3d unrotate = transposed(toDouble(rotations[own]));
    std::size_t at = 0;
    for (std::size_t j = 0; j < bones.size(); ++j) {
        if (j == own) continue;
        const Vec3d center = toDouble(recipe.joint_centers[j]);
        const Vec3d moved = to_cluster * (applyAffine(bones[j], center) - toDouble(bones[own].translation()));
        for (int i = 0; i < 3; ++i) out[at++] = (moved[i] - center[i]) / recipe.scale;
        const Mat3d turned = unrotate * toDouble(rotations[j]);
        for (std::size_t i = 0; i < 9; ++i) out[at++] = turned.m[i] - (i % 4 == 0 ? 1 : 0);
    }
}

std::vector<double> featureWeights(const FeatureRecipe& recipe, int cluster_joint, Vec3 cluster_center,
                                   const Matrix& raw, std::span<const std::size_t> rows) {
    std::vector<double> weights(recipe.count(), 1.0);
    if (recipe.kind == FeatureKind::kJointAngles) return weights;
    std::size_t at = 0;
    for (std::size_t j = 0; j < recipe.joint_centers.size(); ++j) {
        if (j == std::size_t(cluster_joint)) continue;
        const Vec3d rest = (toDouble(recipe.joint_centers[j]) - toDouble(cluster_center)) / recipe.scale;
        double d2 = 0;
        for (std::size_t r : rows) {
            const Vec3d d = rest + Vec3d{raw(r, at), raw(r, at + 1), raw(r, at + 2)};
            d2 += dot(d, d) / double(rows.size());
        }
        for (std::size_t i = 0; i < 12; ++i) weights[at++] = (i < 3 ? 1 : kRotationWeight) / (kNearness + d2);
    }
    return weights;
}

}  // namespace penumbra
