// Evaluates a model at run time (docs/formulas.md, section 4). setPose() computes the inputs of each cluster's model
// (BodyPose) and the cluster's few scores (ClusterScores), on one thread, which is cheap. evaluateCluster() expands the
// scores to the vertices (combine.h), which is nearly all of the work. Clusters are independent, so the caller may
// spread them over threads.
//
// A composed asset expands its scores to the visibility past the nearby parts, multiplies it by the visibility past the
// far parts at the vertex as it is skinned now (ComposedModel), and adds the residual (docs/formulas.md, section 7).
#include "runtime/evaluate/evaluator.h"

#include <cassert>
#include <cmath>

namespace penumbra {

Evaluator::Shared::Shared(const AssetView& asset) {
    if (!asset.mesh.follower_corners.empty()) turns = turnsOf(asset.model.convention);
}

Evaluator::Evaluator(const AssetView& asset)
    : asset_(&asset),
      path_(evaluatorPaths().back()),
      pose_(asset),
      local_(asset),
      shared_(std::make_shared<const Shared>(asset)) {
    assert(asset.hasCharacter());
    if (asset.model.composition) composed_.emplace(asset);
    if (asset.model.indirect) bounced_.emplace(asset);
    if (asset.transfer) transfer_.emplace(asset);
}

void Evaluator::setQuality(FarQuality quality) {
    if (composed_) composed_->far.setQuality(quality);
}

void Evaluator::setNearFactors(NearFactors factors) {
    if (composed_) composed_->far.setNearFactors(factors);
}

const FarLayout& Evaluator::castLayout() const {
    std::call_once(shared_->cast_once, [&] { shared_->cast = makeCastLayout(*asset_); });
    return shared_->cast;
}

std::span<const float> Evaluator::residualScores(std::size_t cluster) const {
    if (!composed_ || composed_->residual.empty()) return {};
    return composed_->residual.of(cluster);
}

std::span<const float> Evaluator::indirectScores(std::size_t cluster) const {
    return bounced_ ? bounced_->scores.of(cluster) : std::span<const float>();
}

void Evaluator::setPose(std::span<const Affine> bones, std::span<const float> pose) {
    pose_.set(bones, pose);
    evaluateScores(pose);
}

void Evaluator::setPositions(std::span<const Vec3> points, std::span<const float> inputs) {
    pose_.deform(points, inputs);
    evaluateScores(pose_.deformed.pose);
}

void Evaluator::setFrame(std::size_t frame) {
    const AnimationView& animation = asset_->animation;
    if (!deformation()) return setPose(animation.bonesOf(frame), animation.poseOf(frame));
    readPositions(*asset_, frame, pose_.deformed.points);
    setPositions(pose_.deformed.points, animation.inputsOf(frame));
}

void Evaluator::evaluateScores(std::span<const float> pose) {
    double out_of_range = 0;
    for (std::size_t c = 0; c < clusterCount(); ++c) {
        const ClusterView& cluster = asset_->model.clusters[c];
        const std::span<const float> seen = pose_.features.of(cluster.joint);
        out_of_range += double(cluster.vertex_count) * double(local_.scores.regress(c, seen));
        // The range of a composed model is that of its local features.
        if (composed_ && !composed_->residual.empty()) composed_->residual.regress(c, seen);
        if (bounced_) bounced_->scores.regress(c, seen);
    }
    out_of_range_ = std::sqrt(out_of_range / double(firstFollower()));
    if (composed_) composed_->far.setPose(bones());
    if (transfer_) transfer_->setPose(pose);
}

void Evaluator::evaluateCluster(std::size_t cluster, std::span<float> coefficients,
                                const SkinnedVertices& skinned) const {
    const ClusterView& view = asset_->model.clusters[cluster];
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(coefficients.size() == vertexCount() * stride);
    if (transfer_)
        return transfer_->transfer(view.first_vertex, view.first_vertex + view.vertex_count, stride, coefficients);
    if (!composed_)
        return local_.scores.combine(path_, cluster, local_.ambient->clamp(),
                                     coefficients.data() + view.first_vertex * stride);
    evaluateFar(cluster, composed_->far_coefficients, skinned);
    composeCluster(cluster, composed_->far_coefficients, coefficients);
}

void Evaluator::follow(std::size_t begin, std::size_t end, const FollowedFrames& frames,
                       std::span<float> coefficients) const {
    followPoints(asset_->mesh, shared_->turns, begin, end, frames, std::size_t(asset_->model.stride), coefficients);
}

void Evaluator::evaluateFar(std::size_t cluster, std::span<float> far, const SkinnedVertices& skinned) const {
    assert(skinned.positions.empty() || skinned.positions.size() == vertexCount());
    composed_->far.evaluate(*path_.far, pose_.mesh(*asset_, skinned), cluster, far);
}

void Evaluator::evaluateIndirect(std::size_t cluster, std::span<float> indirect) const {
    bounced_->evaluate(path_, cluster, indirect);
}

void Evaluator::evaluateLocal(std::size_t cluster, std::span<float> coefficients) const {
    const std::size_t stride = std::size_t(asset_->model.stride);
    assert(coefficients.size() == vertexCount() * stride);
    local_.scores.combine(path_, cluster, noClamp(stride),
                          coefficients.data() + asset_->model.clusters[cluster].first_vertex * stride);
}

void Evaluator::composeCluster(std::size_t cluster, std::span<const float> far, std::span<float> coefficients) const {
    evaluateLocal(cluster, coefficients);
    composed_->compose(path_, local_.ambient->clamp(), cluster, far, coefficients);
}

void Evaluator::skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
                     std::span<Vec3> tangents) const {
    assert(end <= vertexCount() && positions.size() == vertexCount() && normals.size() == vertexCount() &&
           tangents.size() == vertexCount());
    const std::size_t count = end - begin;
    skin(begin, positions.subspan(begin, count), normals.subspan(begin, count), tangents.subspan(begin, count));
}

}  // namespace penumbra
