#pragma once
// Pose in, per-vertex visibility out: the library that engines link and the CPU statement of what the shaders compute.
// No GL, no files, no threads of its own: calls on different clusters or vertex ranges may run at the same time.
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/runtime/combine.h"
#include "player/runtime/deformation.h"
#include "player/runtime/model_evaluator.h"

namespace penumbra {

class Evaluator {
public:
    // `asset` (with has_model) and the bytes behind it must outlive the evaluator. Decodes the models and
    // lays out a basis of bytes as combine.h wants it, once: copies of an evaluator, each with a pose of its own, share
    // that.
    explicit Evaluator(const AssetView& asset);

    const AssetView& asset() const { return *asset_; }
    // The fastest path of this processor unless this is called: tests go through all of evaluatorPaths().
    void usePath(const EvaluatorPath& path) { path_ = path; }
    std::size_t vertexCount() const { return asset_->mesh.positions.size(); }
    std::size_t clusterCount() const { return asset_->model.clusters.size(); }

    // Features, regression: the scores y of every cluster and each cluster's rotation. `bones` has J skinning matrices;
    // `pose` P numbers, or empty when the model reads bones only. Vertices of a deforming asset stay where they are.
    // Allocates nothing.
    void setPose(std::span<const Affine> bones, std::span<const float> pose);
    // Of an asset whose model is deforming: its vertices. `points`: [Vs] places of the shading points (of a two-sided
    // mesh the fronts, in the bake's order); `inputs`: [X]. Fits the bones, computes what else the model reads, and
    // sets that pose. Allocates nothing.
    void setPositions(std::span<const Vec3> points, std::span<const float> inputs);
    // A frame of the asset's animation; of a deforming one that has playback positions.
    void setFrame(std::size_t frame);
    std::span<const Vec3> points() const { return points_; }               // [Vs], of a deforming asset; else empty
    std::span<const Vec3> pointNormals() const { return point_normals_; }  // [Vs]
    const Deformation* deformation() const { return decoded_->deformation.get(); }  // null unless deforming

    std::span<const Affine> bones() const { return bones_; }   // [J], of the pose
    std::span<const float> scores(std::size_t cluster) const;  // [K]
    // Other scores in their place until the next pose: what a component does can be looked at. May be scores() itself.
    void setScores(std::size_t cluster, std::span<const float> scores);
    const Mat3& clusterRotation(std::size_t cluster) const;  // nearestRotation of the cluster joint's linear part
    // Of the pose: how far what the clusters see is from where training frames had it, about radians; 0: nowhere. Its
    // inputs were clamped to those of training. formats/stage/model_file.h has the formula.
    double outOfRange() const { return out_of_range_; }

    // numbers[v * stride + i] for the cluster's vertices; `numbers` is the array of all vertices, V * stride floats.
    void evaluateCluster(std::size_t cluster, std::span<float> numbers) const;

    // Skinned positions, unit normals and unit tangents of vertices [begin, end); each output array is [V]. Of a
    // deforming asset its given positions and the normals of its triangles (sh/vertex_normals.h).
    // tangent = normalised(R_c t0 - N (N . R_c t0)); where that vanishes, any unit vector orthogonal to N.
    // The rule of skinVertices() (formats/common/mesh.h) in single precision.
    void skin(std::size_t begin, std::size_t end, std::span<Vec3> positions, std::span<Vec3> normals,
              std::span<Vec3> tangents) const;

private:
    // What is made of the asset once; copies share it.
    struct Decoded {
        std::vector<ModelEvaluator> models;                           // [cluster]
        std::vector<std::size_t> first_score;                         // [cluster]
        std::vector<float> ambient_weights;                           // [stride], E = sum of weight times number
        float ambient_norm2 = 0;                                      // sum of squared weights
        std::vector<std::int8_t> pairs;                               // of clusters with a basis of bytes; combine.h
        std::vector<std::size_t> first_pair_byte, first_pair_weight;  // [cluster]
        std::size_t scores = 0, pair_weights = 0, scratch = 0;
        std::vector<bool> absolute;                // [J], joints that stand for a number
        std::unique_ptr<Deformation> deformation;  // of a deforming asset
    };
    const AssetView* asset_;
    std::shared_ptr<const Decoded> decoded_;
    double out_of_range_ = 0;
    std::vector<Affine> bones_;                // [J]
    std::vector<Mat3> bone_rotations_;         // [J]
    std::vector<Mat3> rotations_;              // [cluster]
    std::vector<float> features_;              // [12 (J - 1)] of the joint that was asked for last
    std::vector<float> scratch_;               // of the models
    std::vector<float> scores_;                // of all clusters
    std::vector<float> weights_;               // of one: scores times the components' scales
    std::vector<std::uint32_t> pair_weights_;  // of clusters with a basis of bytes
    std::vector<float> units_;                 // [cluster], of its pair weights
    EvaluatorPath path_;
    // Of a deforming asset; else empty.
    std::vector<Vec3> points_, point_normals_;  // [Vs]
    std::vector<Affine> fitted_bones_;          // [J]
    std::vector<float> pose_;                   // [P], of kDihedrals
    DeformationScratch deformation_scratch_;

    void relativeBoneFeatures(std::size_t joint);
    static std::shared_ptr<const Decoded> decode(const AssetView& asset);
};

}  // namespace penumbra
