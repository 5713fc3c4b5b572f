#pragma once
// The middle of an evaluation: features become the few scores of a cluster, and scores become the coefficients of its
// vertices. An asset has up to three lists of clusters: its model, the residual of a composed one, and light that
// bounces. They have the same vertices.
#include <memory>
#include <span>
#include <vector>

#include "runtime/evaluate/combine.h"
#include "runtime/evaluate/model_evaluator.h"

namespace penumbra {

// Tables that do not change with the pose: models, and bases of bytes in the layout of combine.h.
struct DecodedClusters {
    std::span<const ClusterView> views;                           // [C]
    std::vector<ModelEvaluator> models;                           // [C]
    std::vector<std::size_t> first_score;                         // [C]
    std::vector<std::int8_t> pairs;                               // bytes of all clusters with a basis of bytes
    std::vector<std::size_t> first_pair_byte, first_pair_weight;  // [C]
    std::size_t scores = 0, pair_weights = 0, scratch = 0, most_components = 0;

    DecodedClusters(const ModelView& model, std::span<const ClusterView> clusters);
};

class ClusterScores {
public:
    // `clusters` may be empty, and must outlive this object. Copies share what is decoded.
    ClusterScores(const ModelView& model, std::span<const ClusterView> clusters);

    bool empty() const { return decoded_->views.empty(); }
    // Computes the scores. Returns the square of how far the features are out of the training range. Allocates nothing.
    float regress(std::size_t cluster, std::span<const float> features);
    std::span<const float> of(std::size_t cluster) const;  // [K]
    // `scores` may be those of the cluster.
    void set(std::size_t cluster, std::span<const float> scores);
    // Writes mean + sum of score times component, clamped, for the cluster's vertices: out[vertex_count, stride]. The
    // mean is the cluster's own, or `mean` of floats, which may be `out` itself.
    void combine(const EvaluatorPath& path, std::size_t cluster, const AmbientClamp& clamp, float* out,
                 const float* mean = nullptr) const;

private:
    std::shared_ptr<const DecodedClusters> decoded_;
    std::vector<float> scratch_;               // for the models
    std::vector<float> scores_;                // scores of all clusters, one after the other
    std::vector<float> weights_;               // for one cluster: scores times the components' scales
    std::vector<std::uint32_t> pair_weights_;  // for all clusters with a basis of bytes
    std::vector<float> units_;                 // [C], unit of its pair weights
};

// Returns the means of clusters as floats, one cluster after the other.
std::vector<float> decodedMeans(std::span<const ClusterView> clusters);

}  // namespace penumbra
