#pragma once
// Turns a pose into visibility at every vertex. Engines link this library, and it is the reference for what the
// shaders compute. It has no GL, no files and no threads of its own: calls on different clusters or vertex ranges may
// run at the same time.
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/evaluate/combine.h"
#include "runtime/evaluate/deformation.h"
#include "runtime/evaluate/far_anchors.h"
#include "runtime/evaluate/model_evaluator.h"
#include "runtime/evaluate/transfer_evaluator.h"
#include "sh/far/far_tables.h"

namespace penumbra {

class Evaluator {
public:
    // `asset` (with hasCharacter()) and the bytes behind it must outlive the evaluator. The constructor decodes the
    // models and lays out a basis of bytes as combine.h wants it. Copies of an evaluator, each with a pose of its own,
    // share that.
    explicit Evaluator(const AssetView& asset);

    const AssetView& asset() const { return *asset_; }
    // Replaces the fastest path of this processor, which is the default. Tests go through all of evaluatorPaths().
    void usePath(const EvaluatorPath& path);
    std::size_t vertexCount() const { return asset_->mesh.positions.size(); }
    std::size_t clusterCount() const { return asset_->model.clusters.size(); }

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
    std::span<const Vec3> points() const { return points_; }               // [Vs] of a deforming asset, else empty
    std::span<const Vec3> pointNormals() const { return point_normals_; }  // [Vs]
    const Deformation* deformation() const { return decoded_->deformation.get(); }  // null unless deforming

    std::span<const Affine> bones() const { return bones_; }   // [J] of the pose
    std::span<const float> scores(std::size_t cluster) const;  // [K]
    // The same of the residual of a composed asset; empty where it has none.
    std::span<const float> residualScores(std::size_t cluster) const;
    // The same of the light that bounces; empty where the asset has none.
    std::span<const float> indirectScores(std::size_t cluster) const;
    // Replaces scores until the next pose, so that one can look at what a component does. `scores` may be scores()
    // itself.
    void setScores(std::size_t cluster, std::span<const float> scores);
    // nearestRotation() of the linear part of the cluster's joint
    const Mat3& clusterRotation(std::size_t cluster) const;
    // Returns how far the clusters' inputs of this pose are from where training frames had them, in about radians; 0
    // where all of them are inside. The evaluator clamps inputs to the training range. formats/stage/model_file.h has
    // the formula.
    double outOfRange() const { return out_of_range_; }

    // Writes numbers[v * stride + i] for the cluster's vertices. `numbers` is the array of all vertices, V * stride
    // floats. For a composed asset it skins them on the way, since the far parts are seen from where they are now.
    void evaluateCluster(std::size_t cluster, std::span<float> numbers) const;

    // The evaluator of an asset of transfer, with the pose that was set last; null of any other. Its numbers are the
    // transfer, which evaluateCluster() writes. setTransferLight() is TransferEvaluator::setLight().
    const TransferEvaluator* transfer() const { return transfer_ ? &*transfer_ : nullptr; }
    void setTransferLight(std::span<const Vec3> sh) { transfer_->setLight(sh); }

    // The two halves of that for a composed asset, which otherwise must not be asked for. evaluateFar() writes what the
    // far parts leave visible at the cluster's vertices (farVisibility(), sh/far/far_visibility.h): far[v * kFarNumbers
    // + i] of all vertices. composeCluster() multiplies it by the local visibility and adds the residual.
    bool composed() const { return decoded_->composed != nullptr; }
    // Of the far parts of a composed asset; others have one quality.
    void setQuality(FarQuality quality) { quality_ = quality; }
    void evaluateFar(std::size_t cluster, std::span<float> far) const;
    // Writes the local visibility alone, which composeCluster() begins with, as evaluateCluster() does; not clamped.
    void evaluateLocal(std::size_t cluster, std::span<float> numbers) const;
    void composeCluster(std::size_t cluster, std::span<const float> far, std::span<float> numbers) const;
    // Writes the light that bounces, indirect[v * kIndirectStride + i] for the cluster's vertices
    // (sh/indirect_numbers.h). `indirect` is the array of all vertices. Only where the asset has it.
    bool hasIndirect() const { return asset_->model.indirect.has_value(); }
    void evaluateIndirect(std::size_t cluster, std::span<float> indirect) const;

    // The fields of a composed asset, and its parts in this pose.
    const FarTables& farTables() const { return decoded_->composed->far; }
    const FarLayout& farLayout() const { return decoded_->composed->layouts[std::size_t(quality_)]; }
    std::span<const PosedPart> posedParts() const { return far_pose_.posed; }
    // The anchors at which others cast on this character. They are laid out when they are first asked for.
    const FarLayout& castLayout() const;

    // Writes skinned positions, unit normals and unit tangents of vertices [begin, end); each output array is [V].
    // For a deforming asset these are its given positions and the normals of its triangles (sh/vertex_normals.h).
    // tangent = normalised(R_c t0 - N (N . R_c t0)); where that vanishes, any unit vector orthogonal to N. This is
    // the rule of skinVertices() (formats/common/mesh.h) in single precision.
    void skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
              std::span<Vec3> tangents) const;
    // The same for the vertices from `begin` on; the arrays are as long as what is wanted.
    void skin(std::size_t begin, std::span<Vec3> positions, std::span<Vec3> normals, std::span<Vec3> tangents) const;

private:
    // What composed assets have on top.
    struct Composed {
        FarTables far;
        std::array<FarLayout, 2> layouts;  // kFull, kFast
        std::vector<float> residual_mean;  // [V, stride], or empty

        Composed(const AssetView& asset);
    };
    // Made of the asset once; copies of the evaluator share it. The clusters of a residual follow those of the model,
    // and then those of light that bounces.
    struct Decoded {
        std::vector<const ClusterView*> clusters;  // [cluster]
        std::vector<ModelEvaluator> models;        // [cluster]
        std::vector<std::size_t> first_score;      // [cluster]
        std::vector<float> ambient_weights;        // [stride], E = sum of weight times number
        float ambient_norm2 = 0;                   // sum of squared weights
        std::vector<std::int8_t> pairs;  // bytes of all clusters with a basis of bytes, in the layout of combine.h
        std::vector<std::size_t> first_pair_byte, first_pair_weight;  // [cluster]
        std::size_t scores = 0, pair_weights = 0, scratch = 0;
        std::size_t first_residual = 0, first_indirect = 0;  // clusters; beyond the last where there are none
        std::vector<float> indirect_mean;                    // [V, kIndirectStride], or empty
        std::vector<bool> absolute;                          // [J], true for joints that stand for a number
        std::unique_ptr<Deformation> deformation;            // only for a deforming asset
        std::unique_ptr<Composed> composed;                  // only for a composed asset
        mutable std::once_flag cast_once;
        mutable FarLayout cast;
    };
    const AssetView* asset_;
    std::shared_ptr<const Decoded> decoded_;
    double out_of_range_ = 0;
    std::vector<Affine> bones_;                // [J]
    std::vector<Mat3> bone_rotations_;         // [J]
    std::vector<Mat3> rotations_;              // [cluster]
    std::vector<float> features_;              // [12 (J - 1)] as seen from the joint that was asked for last
    std::vector<float> scratch_;               // for the models
    std::vector<float> scores_;                // of all clusters, one after the other
    std::vector<float> weights_;               // of one cluster: scores times the components' scales
    std::vector<std::uint32_t> pair_weights_;  // of all clusters with a basis of bytes
    std::vector<float> units_;                 // [cluster], unit of its pair weights
    EvaluatorPath path_;
    FarQuality quality_ = FarQuality::kFull;
    std::optional<TransferEvaluator> transfer_;  // only for an asset of transfer
    // Only for a composed asset; else empty.
    FarPose far_pose_;
    // Calls on different clusters write different places of these.
    mutable std::vector<float> far_;      // [V, kFarNumbers]
    mutable std::vector<float> anchors_;  // [FarLayout::values] of the largest layout
    // Only for a deforming asset; else empty.
    std::vector<Vec3> points_, point_normals_;  // [Vs]
    std::vector<Affine> fitted_bones_;          // [J]
    std::vector<float> pose_;                   // [P], only for kDihedrals
    DeformationScratch deformation_scratch_;

    void relativeBoneFeatures(std::size_t joint);
    void regress(std::size_t cluster, std::span<const float> seen, double& out_of_range);
    void combine(std::size_t cluster, const void* mean, bool half_mean, const AmbientClamp& clamp, float* out) const;
    void evaluateRun(const FarRun& run, std::size_t cluster, std::span<float> far) const;
    Receiver skinned(std::size_t vertex, std::size_t cluster) const;
    std::span<const float> scoresOf(std::size_t index) const;
    static std::shared_ptr<const Decoded> decode(const AssetView& asset);
};

}  // namespace penumbra
