#pragma once
// Turns a pose into visibility at every vertex. Engines link this library, and it is the reference for what the
// shaders compute. It has no GL, no files and no threads of its own: calls on different clusters or vertex ranges may
// run at the same time.
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/evaluate/body_pose.h"
#include "runtime/evaluate/followers.h"
#include "runtime/evaluate/vertex_models.h"
#include "runtime/papers/transfer_evaluator.h"

namespace penumbra {

class Evaluator {
public:
    // `asset` (with hasCharacter()) and the bytes behind it must outlive the evaluator. The constructor decodes the
    // models and lays out a basis of bytes as combine.h wants it. Copies of an evaluator, each with a pose of its own,
    // share that.
    explicit Evaluator(const AssetView& asset);

    const AssetView& asset() const { return *asset_; }
    // Replaces the fastest path of this processor, which is the default. Tests go through all of evaluatorPaths().
    void usePath(const EvaluatorPath& path) { path_ = path; }
    std::size_t vertexCount() const { return asset_->mesh.positions.size(); }
    std::size_t clusterCount() const { return asset_->model.clusters.size(); }

    // --- The pose: once a frame, on one thread ---

    // Computes features and regression: the scores y of every cluster and each cluster's rotation. `bones` has J
    // skinning matrices; `pose` has P numbers, or is empty when the model reads bones only. The vertices of a
    // deforming asset stay where they are. Allocates nothing.
    void setPose(std::span<const Affine> bones, std::span<const float> pose);
    // Sets the vertices of an asset whose model is deforming. `points`: [Vs] positions of the shading points (of a
    // two-sided mesh the fronts, in the bake's order); `inputs`: [X]. Fits the bones, computes what else the model
    // reads, and sets that pose. Allocates nothing.
    void setPositions(std::span<const Vec3> points, std::span<const float> inputs);
    // Sets a frame of the asset's animation. A deforming asset must have playback positions.
    void setFrame(std::size_t frame);
    const Deformation* deformation() const { return pose_.deformation.get(); }  // null unless deforming
    std::span<const Vec3> points() const { return pose_.deformed.points; }      // [Vs] of a deforming asset, else empty
    std::span<const Vec3> pointNormals() const { return pose_.deformed.normals; }  // [Vs]
    std::span<const Affine> bones() const { return pose_.features.bones(); }       // [J] of the pose
    const MorphedRest& rest() const { return pose_.rest; }                         // the weights of morph targets

    // Returns how far the clusters' inputs of this pose are from where training frames had them, in about radians; 0
    // where all of them are inside. The evaluator clamps inputs to the training range. formats/stage/model_file.h has
    // the formula.
    double outOfRange() const { return out_of_range_; }
    std::span<const float> scores(std::size_t cluster) const { return local_.scores.of(cluster); }  // [K]
    // The same of the residual of a composed asset, and of the light that bounces; empty where it has none.
    std::span<const float> residualScores(std::size_t cluster) const;
    std::span<const float> indirectScores(std::size_t cluster) const;
    // Replaces scores until the next pose, so that one can look at what a component does. `scores` may be scores()
    // itself.
    void setScores(std::size_t cluster, std::span<const float> scores) { local_.scores.set(cluster, scores); }
    // nearestRotation() of the linear part of the cluster's joint
    const Mat3& clusterRotation(std::size_t cluster) const {
        return pose_.features.rotation(asset_->model.clusters[cluster].joint);
    }

    // --- Vertices: on any threads ---

    // Writes coefficients[v * stride + i] for the cluster's vertices, in the array of all vertices. For a composed
    // asset it skins them on the way, since the far parts are seen from where they are now; where skin() has written
    // all of them in this pose, they may be given.
    void evaluateCluster(std::size_t cluster, std::span<float> coefficients, const SkinnedVertices& skinned = {}) const;
    // The vertices from firstFollower() on are of no cluster. follow() writes those of [begin, end) once all clusters
    // are evaluated, and again after something has multiplied coefficients of points. `frames` and `coefficients` have
    // all vertices.
    std::size_t firstFollower() const { return asset_->mesh.firstFollower(); }
    bool hasFollowers() const { return firstFollower() < vertexCount(); }
    void follow(std::size_t begin, std::size_t end, const FollowedFrames& frames, std::span<float> coefficients) const;
    // Writes skinned positions, unit normals and unit tangents of vertices [begin, end); each output array is [V].
    // For a deforming asset these are its given positions and the normals of its triangles (sh/vertex_normals.h).
    void skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
              std::span<Vec3> tangents) const;
    // The same for the vertices from `begin` on; the arrays are as long as what is wanted.
    void skin(std::size_t begin, std::span<Vec3> positions, std::span<Vec3> normals, std::span<Vec3> tangents) const {
        pose_.mesh(*asset_).skin(begin, positions, normals, tangents);
    }
    // Writes the light that bounces, indirect[v * kIndirectStride + i] for the cluster's vertices
    // (sh/indirect_coefficients.h), in the array of all vertices. Only where the asset has it.
    bool hasIndirect() const { return bounced_.has_value(); }
    void evaluateIndirect(std::size_t cluster, std::span<float> indirect) const;

    // The steps of evaluateCluster() for a composed asset. Call them only if composed(). evaluateFar() writes
    // what the far and near parts leave visible, far[v * kFarCoefficients + i] of all vertices. composeCluster()
    // multiplies it by the local visibility and adds the residual. evaluateLocal() writes the local visibility alone,
    // not clamped.
    bool composed() const { return composed_.has_value(); }
    void evaluateFar(std::size_t cluster, std::span<float> far, const SkinnedVertices& skinned = {}) const;
    void evaluateLocal(std::size_t cluster, std::span<float> coefficients) const;
    void composeCluster(std::size_t cluster, std::span<const float> far, std::span<float> coefficients) const;
    // Sets the quality of the far parts of a composed asset. Other assets have one quality.
    void setQuality(FarQuality quality);
    void setNearFactors(NearFactors factors);  // kWith at first
    const FarTables& farTables() const { return composed_->far.tables(); }
    const FarLayout& farLayout() const { return composed_->far.layout(); }
    std::span<const PosedPart> posedParts() const { return composed_->far.posed(); }
    // The anchors at which others cast on this character. They are laid out when they are first asked for.
    const FarLayout& castLayout() const;

    // The evaluator of an asset of transfer, with the pose that was set last; null of any other. Its coefficients are
    // the transfer, which evaluateCluster() writes. It has paths of its own, and may be given a light.
    TransferEvaluator* transfer() { return transfer_ ? &*transfer_ : nullptr; }

private:
    // Tables for followers and casters, which copies of the evaluator share.
    struct Shared {
        TurnTable turns;  // for the convention; only with followers
        mutable std::once_flag cast_once;
        mutable FarLayout cast;
        explicit Shared(const AssetView& asset);
    };
    const AssetView* asset_;
    EvaluatorPath path_;
    // The order of a frame: a pose is set, the models' scores follow from what they see of it, and the vertices of each
    // cluster follow from the scores.
    BodyPose pose_;
    LocalModel local_;
    std::optional<ComposedModel> composed_;
    std::optional<BouncedLight> bounced_;
    std::optional<TransferEvaluator> transfer_;  // in place of all models
    std::shared_ptr<const Shared> shared_;
    double out_of_range_ = 0;

    void evaluateScores(std::span<const float> pose);
};

}  // namespace penumbra
