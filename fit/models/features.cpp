#include "fit/models/features.h"

#include <cassert>
#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "sh/pose_inputs.h"

namespace penumbra {

namespace {

constexpr double kSingular = 1e-9;
constexpr double kNearness = 0.02;  // in box diagonals squared; keeps the weight of the nearest bones finite
constexpr double kBoneExponent = 2, kDeformingExponent = 1;
constexpr double kInputWeight = 3;
constexpr double kRotationWeight = 0.3;
constexpr double kNumberDistance = 0.1;  // squared distance that an input counts as having when it is not a point

// Returns the inverse of a bone's linear part, or of its rotation when the linear part cannot be inverted.
Mat3d inverseLinear(const Affine& bone, const Mat3& rotation) {
    const Mat3d a = toDouble(bone.linear()), c = cofactor(a);
    const double det = a.m[0] * c.m[0] + a.m[1] * c.m[1] + a.m[2] * c.m[2];
    if (std::abs(det) < kSingular) return transposed(toDouble(rotation));
    Mat3d inverse = transposed(c);
    for (double& x : inverse.m) x /= det;
    return inverse;
}

Vec3d applyAffine(const Affine& bone, Vec3d p) { return toDouble(bone.linear()) * p + toDouble(bone.translation()); }

// Returns, for each joint [J], the mean over `rows` of the squared distance of its center from the cluster's, in box
// diagonals. It is 0 for the cluster's own joint.
std::vector<double> squaredDistances(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                     std::span<const std::size_t> rows) {
    std::vector<double> distances(recipe.joint_centers.size());
    std::size_t at = 0;
    for (std::size_t j = 0; j < distances.size(); ++j) {
        if (j == std::size_t(place.joint)) continue;
        if (recipe.absolute(j)) {
            // An input that is not a point has no distance, unless it is the weight of a morph target.
            const Vec3d way = (toDouble(recipe.joint_centers[j]) - toDouble(place.center)) / recipe.scale;
            distances[j] = recipe.joint_centers[j] == Vec3{} ? kNumberDistance : dot(way, way);
            at += 12;
            continue;
        }
        const Vec3d rest = (toDouble(recipe.joint_centers[j]) - toDouble(place.center)) / recipe.scale;
        // The raw features hold how far the joint's center has moved; adding its rest position gives where it is.
        for (std::size_t r : rows) {
            const Vec3d d = rest + Vec3d{raw(r, at), raw(r, at + 1), raw(r, at + 2)};
            distances[j] += dot(d, d) / double(rows.size());
        }
        at += 12;
    }
    return distances;
}

}  // namespace

FeatureRecipe recipeOf(const Model& model) {
    return {model.features,      model.feature_scale,          model.joint_centers,
            model.joint_spreads, std::size_t(model.pose_size), model.deforming,
            model.input_joints,  model.input_names.size()};
}

bool FeatureRecipe::absolute(std::size_t joint) const {
    for (const InputJoint& input : input_joints)
        if (input.joint == joint) return input.absolute();
    return false;
}

std::size_t FeatureRecipe::groups() const { return groupCount(kind, joint_centers.size(), pose_size); }

std::size_t FeatureRecipe::count() const { return featureCount(kind, joint_centers.size(), pose_size); }

void rawFeatures(const FeatureRecipe& recipe, int cluster_joint, std::span<const Affine> bones,
                 std::span<const Mat3> rotations, std::span<const float> pose, std::span<double> out) {
    assert(out.size() == recipe.count());
    if (recipe.kind != FeatureKind::kRelativeBones) {
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = pose[i];
        return;
    }
    const auto own = std::size_t(cluster_joint);
    // 1. The map from the model frame into the frame of the cluster's bone.
    const Mat3d to_cluster = inverseLinear(bones[own], rotations[own]);
    const Mat3d unrotate = transposed(toDouble(rotations[own]));
    std::size_t at = 0;
    for (std::size_t j = 0; j < bones.size(); ++j) {
        if (j == own) continue;
        const Vec3d center = toDouble(recipe.joint_centers[j]);
        if (recipe.absolute(j)) {
            // 2. An input that is not a point gives its number as it is.
            const Vec3d way = (applyAffine(bones[j], center) - center) / recipe.scale;
            for (int i = 0; i < 12; ++i) out[at++] = i < 3 ? way[i] : 0;
            continue;
        }
        const Vec3d moved = to_cluster * (applyAffine(bones[j], center) - toDouble(bones[own].translation()));
        // 3. Any other bone gives the displacement of its center and its rotation, both relative to the cluster's bone.
        for (int i = 0; i < 3; ++i) out[at++] = (moved[i] - center[i]) / recipe.scale;
        const Mat3d turned = unrotate * toDouble(rotations[j]);
        for (std::size_t i = 0; i < 9; ++i) out[at++] = turned.m[i] - (i % 4 == 0 ? 1 : 0);
    }
}

std::vector<Mat3> jointSpreads(const Mesh& mesh, const Skin& skin, const std::vector<Vec3>& centers, double scale) {
    // 1. Sum the weighted outer products of the offsets of each joint's vertices.
    std::vector<Eigen::Matrix3d> sum(skin.jointCount(), Eigen::Matrix3d::Zero());
    std::vector<double> weight(skin.jointCount());
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
        for (std::size_t i = v * std::size_t(skin.influences); i < (v + 1) * std::size_t(skin.influences); ++i) {
            const std::size_t j = skin.joints[i];
            const Vec3d d = (toDouble(mesh.rest_positions[v]) - toDouble(centers[j])) / scale;
            const Eigen::Vector3d offset(d.x, d.y, d.z);
            sum[j] += double(skin.weights[i]) * offset * offset.transpose();
            weight[j] += skin.weights[i];
        }
    // 2. Take the symmetric square root of each mean.
    std::vector<Mat3> spreads;
    for (std::size_t j = 0; j < sum.size(); ++j) {
        const EigenPairs3 axes = symmetricEigenPairs(weight[j] > 0 ? (sum[j] / weight[j]).eval() : sum[j]);
        const Eigen::Matrix3d root =
            axes.vectors * axes.values.cwiseMax(0).cwiseSqrt().asDiagonal() * axes.vectors.transpose();
        Mat3& spread = spreads.emplace_back();
        for (int i = 0; i < 9; ++i) spread.m[std::size_t(i)] = float(root(i / 3, i % 3));
    }
    return spreads;
}

void readGroup(const FeatureRecipe& recipe, const ClusterPlace& place, std::size_t group, std::span<const double> raw,
               std::span<double> out) {
    assert(out.size() == groupInputs(recipe.kind));
    if (recipe.kind != FeatureKind::kRelativeBones) {
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = raw[out.size() * group + i];
        return;
    }
    // The raw features leave out the cluster's own joint, so later joints stand one place earlier.
    assert(group != std::size_t(place.joint));
    const double* bone = raw.data() + 12 * (group - (group > std::size_t(place.joint) ? 1 : 0));
    if (recipe.absolute(group)) {
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = i < 3 ? bone[i] : 0;
        return;
    }
    const Vec3d rest = (toDouble(recipe.joint_centers[group]) - toDouble(place.center)) / recipe.scale;
    Mat3d turned;
    for (std::size_t i = 0; i < 9; ++i) turned.m[i] = bone[3 + i];
    boneInputs(rest + Vec3d{bone[0], bone[1], bone[2]}, turned, toDouble(recipe.joint_spreads[group]), out.data());
}

namespace {

// Reduced angles keep their variances, of which the first is 1. Inputs stand in the last columns and are scaled to a
// variance of 1.
std::vector<double> angleWeights(const FeatureRecipe& recipe, const Matrix& raw, std::span<const std::size_t> rows) {
    std::vector<double> weights(recipe.count(), 1.0);
    for (std::size_t c = weights.size() - recipe.input_count; c < weights.size(); ++c) {
        double mean = 0, variance = 0;
        for (std::size_t r : rows) mean += raw(r, c) / double(rows.size());
        for (std::size_t r : rows) variance += (raw(r, c) - mean) * (raw(r, c) - mean) / double(rows.size());
        weights[c] = variance > 0 ? 1 / std::sqrt(variance) : 0;
    }
    return weights;
}

}  // namespace

std::vector<double> featureWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                   std::span<const std::size_t> rows) {
    if (recipe.kind == FeatureKind::kDihedrals) return angleWeights(recipe, raw, rows);
    std::vector<double> weights(recipe.count(), 1.0);
    if (recipe.kind == FeatureKind::kJointAngles) return weights;
    const std::vector<double> distances = squaredDistances(recipe, place, raw, rows);
    std::size_t at = 0;
    for (std::size_t j = 0; j < distances.size(); ++j)
        for (std::size_t i = 0; i < 12 && j != std::size_t(place.joint); ++i)
            weights[at++] = recipe.sees(j) ? (i < 3 ? 1 : kRotationWeight) / (kNearness + distances[j]) : 0;
    return weights;
}

std::vector<double> groupWeights(const FeatureRecipe& recipe, const ClusterPlace& place, const Matrix& raw,
                                 std::span<const std::size_t> rows) {
    std::vector<double> weights(recipe.groups(), 1.0);
    if (recipe.kind == FeatureKind::kRelativeBones) {
        const std::vector<double> distances = squaredDistances(recipe, place, raw, rows);
        const double exponent = recipe.deforming ? kDeformingExponent : kBoneExponent;
        for (std::size_t j = 0; j < weights.size(); ++j) weights[j] = std::pow(kNearness + distances[j], -exponent);
        for (const InputJoint& input : recipe.input_joints) weights[input.joint] *= kInputWeight;
        weights[std::size_t(place.joint)] = 0;
        for (std::size_t j = 0; j < weights.size(); ++j)
            if (!recipe.sees(j)) weights[j] = 0;
    }
    double sum = 0;
    for (double w : weights) sum += w;
    for (double& w : weights) w /= sum > 0 ? sum : 1;
    return weights;
}

}  // namespace penumbra
