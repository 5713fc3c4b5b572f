#include "player/runtime/evaluator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace penumbra {

// combined = weights input_basis, transposed to [N, K]; offset = bias - combined feature_mean. Sums in double: the
// mean of a feature is large against its changes.
static void combineRegressor(const ClusterView& cluster, std::vector<float>& combined, std::vector<float>& offset) {
    const std::size_t features = cluster.feature_mean.size(), inputs = cluster.inputs();
    const std::size_t components = cluster.components();
    std::vector<float> basis(inputs * features);
    decode(cluster.input_basis, basis);
    combined.resize(features * components);
    offset.resize(components);
    std::vector<double> row(features);
    for (std::size_t k = 0; k < components; ++k) {
        std::fill(row.begin(), row.end(), 0.0);
        for (std::size_t i = 0; i < inputs; ++i)
            for (std::size_t n = 0; n < features; ++n)
                row[n] += double(cluster.weights[k * inputs + i]) * basis[i * features + n];
        double sum = cluster.bias[k];
        for (std::size_t n = 0; n < features; ++n) {
            combined[n * components + k] = float(row[n]);
            sum -= double(float(row[n])) * cluster.feature_mean[n];
        }
        offset[k] = float(sum);
    }
}

Evaluator::Evaluator(const AssetView& asset) : asset_(&asset), path_(evaluatorPaths().back()) {
    assert(asset.has_model);
    std::size_t scores = 0, features = 0;
    for (const ClusterView& cluster : asset.model.clusters) {
        Regressor& regressor = regressors_.emplace_back();
        combineRegressor(cluster, regressor.combined, regressor.offset);
        regressor.first_score = scores;
        scores += cluster.components();
        features = std::max(features, cluster.feature_mean.size());
    }
    bones_.resize(asset.animation.jointCount());
    bone_rotations_.resize(bones_.size());
    rotations_.resize(clusterCount());
    features_.resize(features);
    scores_.resize(scores);
    weights_.resize(scores);
}

// M_c^-1 M_j centre_j - centre_j in units of feature_scale and R_c^T R_j - I, for every joint j but c (model_file.h). A
// bone that cannot be inverted (scaled to nothing) sees the others where its rotation alone would put them.
void Evaluator::relativeBoneFeatures(std::size_t joint) {
    const Mat3 linear = bones_[joint].linear(), adjugate = transposed(cofactor(linear));
    const float determinant =
        dot(Vec3{linear.m[0], linear.m[1], linear.m[2]}, Vec3{adjugate.m[0], adjugate.m[3], adjugate.m[6]});
    const Mat3 to_rest = transposed(bone_rotations_[joint]);
    const float scale = 1 / asset_->model.feature_scale;
    float* out = features_.data();
    for (std::size_t j = 0; j < bones_.size(); ++j) {
        if (j == joint) continue;
        const Vec3 centre = asset_->model.joint_centers[j];
        const Vec3 offset = bones_[j].point(centre) - bones_[joint].translation();
        const Vec3 seen = determinant != 0 ? (adjugate * offset) / determinant : to_rest * offset;
        const Vec3 moved = (seen - centre) * scale;
        const Mat3 turned = to_rest * bone_rotations_[j];
        for (int i = 0; i < 3; ++i) *out++ = moved[i];
        for (int i = 0; i < 9; ++i) *out++ = turned.m[i] - (i % 4 == 0 ? 1.0f : 0.0f);
    }
}

// scores = offset + combined^T features.
static void regress(std::span<const float> combined, std::span<const float> offset, std::span<const float> features,
                    std::span<float> scores) {
    std::copy(offset.begin(), offset.end(), scores.begin());
    const std::size_t components = scores.size();
    const float* row = combined.data();
    for (float feature : features) {
        for (std::size_t k = 0; k < components; ++k) scores[k] += feature * row[k];
        row += components;
    }
}

void Evaluator::setPose(std::span<const Affine> bones, std::span<const float> pose) {
    const ModelView& model = asset_->model;
    const bool angles = model.features == AssetFeatures::kJointAngles;
    assert(bones.size() == bones_.size() && (!angles || pose.size() == features_.size()));
    std::copy(bones.begin(), bones.end(), bones_.begin());
    for (std::size_t j = 0; j < bones.size(); ++j) bone_rotations_[j] = nearestRotation(bones[j].linear());
    int features_of = -1;  // joint
    for (std::size_t c = 0; c < clusterCount(); ++c) {
        const ClusterView& cluster = model.clusters[c];
        rotations_[c] = bone_rotations_[std::size_t(cluster.joint)];
        if (!angles && features_of != cluster.joint) relativeBoneFeatures(std::size_t(cluster.joint));
        features_of = cluster.joint;
        const Regressor& regressor = regressors_[c];
        const std::span<float> y = std::span(scores_).subspan(regressor.first_score, cluster.components());
        regress(regressor.combined, regressor.offset, angles ? pose : std::span<const float>(features_), y);
        for (std::size_t k = 0; k < y.size(); ++k)
            weights_[regressor.first_score + k] = cluster.basis.scale.empty() ? y[k] : y[k] * cluster.basis.scale[k];
    }
}

std::span<const float> Evaluator::scores(std::size_t cluster) const {
    return std::span(scores_).subspan(regressors_[cluster].first_score, asset_->model.clusters[cluster].components());
}

const Mat3& Evaluator::clusterRotation(std::size_t cluster) const { return rotations_[cluster]; }

void Evaluator::evaluateCluster(std::size_t cluster, std::span<float> numbers) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(numbers.size() == vertexCount() * stride);
    const CombineInput input{view.mean.data,    view.mean.precision == AssetPrecision::kF16,
                             view.basis.data,   weights_.data() + regressors_[cluster].first_score,
                             view.components(), view.mean.count};
    float* out = numbers.data() + view.first_vertex * stride;
    switch (view.basis.precision) {
        case AssetPrecision::kF32:
            return path_.f32(input, out);
        case AssetPrecision::kF16:
            return path_.f16(input, out);
        case AssetPrecision::kI8:
            return path_.i8(input, out);
    }
}

static Affine blendBones(const MeshView& mesh, std::size_t vertex, std::span<const Affine> bones) {
    Affine blend;
    blend.m.fill(0);
    const std::size_t first = vertex * std::size_t(mesh.influences);
    for (std::size_t k = first; k < first + std::size_t(mesh.influences); ++k) {
        const float weight = mesh.skin_weights[k];
        if (weight == 0) continue;
        const Affine& bone = bones[mesh.skin_joints[k]];
        for (int e = 0; e < 12; ++e) blend.m[e] += weight * bone.m[e];
    }
    return blend;
}

// `wanted` made orthogonal to the unit `normal`; when nothing is left, the axis least along the normal is taken
// instead.
static Vec3 tangentOf(Vec3 normal, Vec3 wanted) {
    const Vec3 tangent = wanted - normal * dot(normal, wanted);
    if (dot(tangent, tangent) > 1e-12f) return normalized(tangent);
    const Vec3 a{std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)};
    const Vec3 axis = a.x <= a.y && a.x <= a.z ? Vec3{1, 0, 0} : a.y <= a.z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    return normalized(axis - normal * dot(normal, axis));
}

void Evaluator::skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(end <= vertexCount() && positions.size() == vertexCount() && normals.size() == vertexCount() &&
           tangents.size() == vertexCount());
    const MeshView& mesh = asset_->mesh;
    const std::vector<ClusterView>& clusters = asset_->model.clusters;
    const auto after = std::upper_bound(clusters.begin(), clusters.end(), begin,
                                        [](std::size_t v, const ClusterView& c) { return v < c.first_vertex; });
    std::size_t cluster = std::size_t(after - clusters.begin()) - 1;
    for (std::size_t v = begin; v < end; ++v) {
        if (v >= clusters[cluster].first_vertex + std::size_t(clusters[cluster].vertex_count)) ++cluster;
        const Affine blend = blendBones(mesh, v, bones_);
        positions[v] = blend.point(mesh.positions[v]);
        normals[v] = normalized(cofactor(blend.linear()) * mesh.normals[v]);
        tangents[v] = tangentOf(normals[v], rotations_[cluster] * mesh.tangents[v]);
    }
}

}  // namespace penumbra
