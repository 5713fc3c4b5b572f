#pragma once
// The last step of an evaluation: the scores of a cluster become the numbers of its vertices. The local model has what
// every vertex sees, or in a composed asset what it sees past nearby parts. The composed model multiplies that by what
// the far parts leave visible and adds its residual. The bounced light is beside them.
//
// Calls on different clusters may run at the same time. Copies share what is decoded, and the asset outlives them.
#include <memory>
#include <span>
#include <vector>

#include "runtime/evaluate/cluster_scores.h"
#include "runtime/evaluate/far_evaluator.h"

namespace penumbra {

// E of a vertex is the sum of weight times number.
struct AmbientWeights {
    std::vector<float> weights;  // [stride]
    float norm2 = 0;             // sum of squared weights

    explicit AmbientWeights(const ModelView& model);
    AmbientClamp clamp() const { return {weights.data(), weights.size(), norm2}; }
};

struct LocalModel {
    ClusterScores scores;
    std::shared_ptr<const AmbientWeights> ambient;

    explicit LocalModel(const AssetView& asset);
};

struct ComposedModel {
    const AssetView* asset;
    FarEvaluator far;
    ClusterScores residual;                                   // empty where there is none
    std::shared_ptr<const std::vector<float>> residual_mean;  // [V, stride], or empty
    mutable std::vector<float> far_coefficients;  // [V, kFarCoefficients], memory that evaluations use on the way

    explicit ComposedModel(const AssetView& of);  // the asset must have a composition
    // Multiplies the local visibility of a cluster, which stands in `coefficients` [V, stride], by `far_factors` [V,
    // kFarCoefficients], and adds the residual.
    void compose(const EvaluatorPath& path, const AmbientClamp& clamp, std::size_t cluster,
                 std::span<const float> far_factors, std::span<float> coefficients) const;
};

struct BouncedLight {
    const AssetView* asset;
    ClusterScores scores;
    std::shared_ptr<const std::vector<float>> mean;  // [V, kIndirectStride]

    explicit BouncedLight(const AssetView& of);  // the asset must have light that bounces
    // Writes the numbers of a cluster in `indirect` [V, kIndirectStride].
    void evaluate(const EvaluatorPath& path, std::size_t cluster, std::span<float> indirect) const;
};

// Clamps nothing.
AmbientClamp noClamp(std::size_t stride);

}  // namespace penumbra
