// Evaluates a model at run time (docs/formulas.md, section 4).
//
// Problem: every frame, turn the skinning matrices of a character into a few coefficients of visibility for each
// vertex, in a fraction of a millisecond, on any number of threads.
//
// Naive: evaluate one regression for each vertex. That would read far more coefficients than a frame has time for.
//
// Here: vertices form clusters. setPose() computes for each cluster what its model sees (PoseFeatures) and the
// cluster's few scores (ClusterScores), once and on one thread. That is cheap. evaluateCluster() then expands the
// scores to the vertices (combine.h), which is nearly all of the work, and clusters are independent, so that the caller
// may spread them over threads.
//
// A composed asset expands its scores to what each vertex sees past the nearby parts, multiplies that by what the far
// parts leave visible at the vertex as it is skinned now (FarEvaluator), and adds the residual (docs/formulas.md,
// section 7).
#include "runtime/evaluate/evaluator.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "sh/indirect_numbers.h"

namespace penumbra {

namespace {

std::span<const ClusterView> residualOf(const AssetView& asset) {
    if (!asset.model.composition) return {};
    return asset.model.composition->residual;
}

std::span<const ClusterView> indirectOf(const AssetView& asset) {
    if (!asset.model.indirect) return {};
    return asset.model.indirect->clusters;
}

}  // namespace

Evaluator::Shared::Shared(const AssetView& asset)
    : ambient_weights(std::size_t(asset.model.stride)),
      residual_mean(decodedMeans(residualOf(asset))),
      indirect_mean(decodedMeans(indirectOf(asset))) {
    ambientWeights(asset.model.convention,
                   std::span(ambient_weights).first(std::size_t(asset.model.convention.size())));
    for (float weight : ambient_weights) ambient_norm2 += weight * weight;
    if (!asset.mesh.follower_corners.empty()) turns = turnsOf(asset.model.convention);
}

Evaluator::Evaluator(const AssetView& asset)
    : asset_(&asset),
      shared_(std::make_shared<const Shared>(asset)),
      path_(evaluatorPaths().back()),
      features_(asset),
      rest_(asset),
      model_(asset.model, asset.model.clusters),
      residual_(asset.model, residualOf(asset)),
      indirect_(asset.model, indirectOf(asset)) {
    assert(asset.hasCharacter());
    if (asset.transfer) transfer_.emplace(asset);
    if (asset.model.composition) {
        far_.emplace(asset);
        far_factors_.resize(vertexCount() * kFarNumbers);
    }
    if (!asset.model.deforming) return;
    deformation_ = std::make_shared<const Deformation>(asset);
    deformed_ = deformation_->atRest();
}

void Evaluator::setQuality(FarQuality quality) {
    if (far_) far_->setQuality(quality);
}

void Evaluator::setNearFactors(NearFactors factors) {
    if (far_) far_->setNearFactors(factors);
}

const FarLayout& Evaluator::castLayout() const {
    std::call_once(shared_->cast_once, [&] { shared_->cast = makeCastLayout(*asset_); });
    return shared_->cast;
}

void Evaluator::setPose(std::span<const Affine> bones, std::span<const float> pose) {
    features_.set(bones, pose);
    rest_.setPose(bones);
    double out_of_range = 0;
    for (std::size_t c = 0; c < clusterCount(); ++c) {
        const ClusterView& cluster = asset_->model.clusters[c];
        const std::span<const float> seen = features_.of(cluster.joint);
        out_of_range += double(cluster.vertex_count) * double(model_.regress(c, seen));
        // The range of a composed model is that of its local features.
        if (!residual_.empty()) residual_.regress(c, seen);
        if (!indirect_.empty()) indirect_.regress(c, seen);
    }
    out_of_range_ = std::sqrt(out_of_range / double(firstFollower()));
    if (far_) far_->setPose(features_.bones());
    if (transfer_) transfer_->setPose(pose);
}

void Evaluator::setPositions(std::span<const Vec3> points, std::span<const float> inputs) {
    assert(points.size() == deformed_.points.size());
    if (points.data() != deformed_.points.data()) std::copy(points.begin(), points.end(), deformed_.points.begin());
    deformation_->follow(inputs, deformed_);
    setPose(deformed_.bones, deformed_.pose);
}

void Evaluator::setFrame(std::size_t frame) {
    const AnimationView& animation = asset_->animation;
    if (!deformation_) return setPose(animation.bonesOf(frame), animation.poseOf(frame));
    readPositions(*asset_, frame, deformed_.points);
    setPositions(deformed_.points, animation.inputsOf(frame));
}

AmbientClamp Evaluator::clamp() const {
    return {shared_->ambient_weights.data(), shared_->ambient_weights.size(), shared_->ambient_norm2};
}

void Evaluator::evaluateCluster(std::size_t cluster, std::span<float> coefficients) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(coefficients.size() == vertexCount() * stride);
    if (transfer_)
        return transfer_->transfer(view.first_vertex, view.first_vertex + view.vertex_count, stride, coefficients);
    if (!far_) return model_.combine(path_, cluster, clamp(), coefficients.data() + view.first_vertex * stride);
    evaluateFar(cluster, far_factors_);
    composeCluster(cluster, far_factors_, coefficients);
}

void Evaluator::follow(std::size_t begin, std::size_t end, const FollowedFrames& frames,
                       std::span<float> coefficients) const {
    followPoints(asset_->mesh, shared_->turns, begin, end, frames, std::size_t(asset_->model.stride), coefficients);
}

void Evaluator::evaluateFar(std::size_t cluster, std::span<float> far) const {
    far_->evaluate(*path_.far, mesh(), cluster, far);
}

namespace {

constexpr std::array<float, coefficientCount(kMaxOrder)> kNoWeights{};  // these clamp nothing

}  // namespace

void Evaluator::evaluateIndirect(std::size_t cluster, std::span<float> indirect) const {
    assert(hasIndirect() && indirect.size() == vertexCount() * kIndirectStride);
    const std::size_t first = asset_->model.clusters[cluster].first_vertex * kIndirectStride;
    indirect_.combine(path_, cluster, {kNoWeights.data(), kIndirectStride, 1}, indirect.data() + first,
                      shared_->indirect_mean.data() + first);
}

void Evaluator::evaluateLocal(std::size_t cluster, std::span<float> coefficients) const {
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(coefficients.size() == vertexCount() * stride);
    model_.combine(path_, cluster, {kNoWeights.data(), stride, 1},
                   coefficients.data() + asset_->model.clusters[cluster].first_vertex * stride);
}

void Evaluator::composeCluster(std::size_t cluster, std::span<const float> far, std::span<float> coefficients) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride), first = view.first_vertex * stride;
    assert(far.size() == vertexCount() * kFarNumbers);
    // 1. What the vertices see past the nearby parts.
    evaluateLocal(cluster, coefficients);
    float* const out = coefficients.data() + first;
    // 2. Times what the far parts leave visible, plus the mean of the residual.
    const float* mean = residual_.empty() ? nullptr : shared_->residual_mean.data() + first;
    path_.far->compose(far_->tables().constants(), far.data() + view.first_vertex * kFarNumbers, mean,
                       view.vertex_count, stride, out);
    // 3. The components of the residual.
    if (mean)
        residual_.combine(path_, cluster, clamp(), out, out);
    else
        path_.clamp(clamp(), out, view.vertex_count);
}

void Evaluator::skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(end <= vertexCount() && positions.size() == vertexCount() && normals.size() == vertexCount() &&
           tangents.size() == vertexCount());
    const std::size_t count = end - begin;
    skin(begin, positions.subspan(begin, count), normals.subspan(begin, count), tangents.subspan(begin, count));
}

}  // namespace penumbra
