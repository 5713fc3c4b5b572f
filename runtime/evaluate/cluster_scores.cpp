#include "runtime/evaluate/cluster_scores.h"

#include <algorithm>

namespace penumbra {

namespace {

bool hasBytes(const ClusterView& cluster) { return cluster.basis.precision == AssetPrecision::kI8; }

}  // namespace

DecodedClusters::DecodedClusters(const ModelView& model, std::span<const ClusterView> clusters) : views(clusters) {
    for (const ClusterView& cluster : clusters) {
        const ModelEvaluator& one = models.emplace_back(model, cluster);
        first_score.push_back(scores);
        scores += one.components();
        most_components = std::max(most_components, one.components());
        scratch = std::max(scratch, one.scratchSize());
        first_pair_byte.push_back(pairs.size());
        first_pair_weight.push_back(pair_weights);
        if (!hasBytes(cluster)) continue;
        appendPairs(reinterpret_cast<const std::int8_t*>(cluster.basis.data), cluster.components(), cluster.mean.count,
                    pairs);
        pair_weights += (cluster.components() + 1) / 2;
    }
    pairs.shrink_to_fit();
}

ClusterScores::ClusterScores(const ModelView& model, std::span<const ClusterView> clusters)
    : decoded_(std::make_shared<const DecodedClusters>(model, clusters)),
      scratch_(decoded_->scratch),
      scores_(decoded_->scores),
      weights_(decoded_->most_components),
      pair_weights_(decoded_->pair_weights),
      units_(clusters.size()) {}

float ClusterScores::regress(std::size_t cluster, std::span<const float> features) {
    const std::span<float> y =
        std::span(scores_).subspan(decoded_->first_score[cluster], decoded_->views[cluster].components());
    const float out_of_range = decoded_->models[cluster].evaluate(features, scratch_, y);
    set(cluster, y);
    return out_of_range;
}

std::span<const float> ClusterScores::of(std::size_t cluster) const {
    return std::span(scores_).subspan(decoded_->first_score[cluster], decoded_->views[cluster].components());
}

void ClusterScores::set(std::size_t cluster, std::span<const float> scores) {
    const ClusterView& view = decoded_->views[cluster];
    for (std::size_t k = 0; k < scores.size(); ++k) scores_[decoded_->first_score[cluster] + k] = scores[k];
    if (!hasBytes(view)) return;
    // combine.h multiplies bytes by 16-bit weights, so the scales go into the weights first.
    for (std::size_t k = 0; k < scores.size(); ++k) weights_[k] = scores[k] * view.basis.scale[k];
    const std::size_t first = decoded_->first_pair_weight[cluster];
    units_[cluster] = packWeights(std::span<const float>(weights_).first(scores.size()),
                                  std::span(pair_weights_).subspan(first, (scores.size() + 1) / 2));
}

void ClusterScores::combine(const EvaluatorPath& path, std::size_t cluster, const AmbientClamp& clamp, float* out,
                            const float* mean) const {
    const DecodedClusters& d = *decoded_;
    const ClusterView& view = d.views[cluster];
    const void* const start = mean ? static_cast<const void*>(mean) : view.mean.data;
    const bool half = !mean && view.mean.precision == AssetPrecision::kF16;
    const std::size_t components = view.components(), count = view.mean.count;
    // A basis of bytes is combined and clamped in one call; halves and floats are clamped afterwards.
    if (hasBytes(view)) {
        const std::int8_t* const bytes = d.pairs.data() + d.first_pair_byte[cluster];
        const std::uint32_t* const weights = pair_weights_.data() + d.first_pair_weight[cluster];
        return path.i8({start, half, bytes, weights, units_[cluster], (components + 1) / 2, count}, clamp, out);
    }
    const CombineInput input{start, half, view.basis.data, scores_.data() + d.first_score[cluster], components, count};
    (view.basis.precision == AssetPrecision::kF16 ? path.f16 : path.f32)(input, out);
    path.clamp(clamp, out, view.vertex_count);
}

std::vector<float> decodedMeans(std::span<const ClusterView> clusters) {
    std::vector<float> means;
    for (const ClusterView& cluster : clusters) {
        const std::size_t begin = means.size();
        means.resize(begin + cluster.mean.count);
        decode(cluster.mean, std::span(means).subspan(begin));
    }
    return means;
}

}  // namespace penumbra
