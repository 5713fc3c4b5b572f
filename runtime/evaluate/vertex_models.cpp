#include "runtime/evaluate/vertex_models.h"

#include <array>
#include <cassert>

#include "sh/indirect_coefficients.h"

namespace penumbra {

namespace {

std::shared_ptr<const std::vector<float>> meansOf(std::span<const ClusterView> clusters) {
    return std::make_shared<const std::vector<float>>(decodedMeans(clusters));
}

}  // namespace

AmbientClamp noClamp(std::size_t stride) {
    static constexpr std::array<float, coefficientCount(kMaxOrder)> kNoWeights{};
    assert(stride <= kNoWeights.size());
    return {kNoWeights.data(), stride, 1};
}

AmbientWeights::AmbientWeights(const ModelView& model) : weights(std::size_t(model.stride)) {
    ambientWeights(model.convention, std::span(weights).first(std::size_t(model.convention.size())));
    for (const float weight : weights) norm2 += weight * weight;
}

LocalModel::LocalModel(const AssetView& asset)
    : scores(asset.model, asset.model.clusters), ambient(std::make_shared<const AmbientWeights>(asset.model)) {}

ComposedModel::ComposedModel(const AssetView& of)
    : asset(&of),
      far(of),
      residual(of.model, of.model.composition->residual),
      residual_mean(meansOf(of.model.composition->residual)),
      far_coefficients(of.mesh.positions.size() * kFarCoefficients) {}

void ComposedModel::compose(const EvaluatorPath& path, const AmbientClamp& clamp, std::size_t cluster,
                            std::span<const float> far_factors, std::span<float> coefficients) const {
    const ClusterView& view = asset->model.clusters[cluster];
    const std::size_t stride = clamp.stride, first = view.first_vertex * stride;
    assert(far_factors.size() == asset->mesh.positions.size() * kFarCoefficients);
    float* const out = coefficients.data() + first;
    // 1. Multiply by what the far parts leave visible, and add the mean of the residual.
    const float* const mean = residual.empty() ? nullptr : residual_mean->data() + first;
    path.far->compose(far.tables().constants(), far_factors.data() + view.first_vertex * kFarCoefficients, mean,
                      view.vertex_count, stride, out);
    // 2. Add the components of the residual.
    if (mean)
        residual.combine(path, cluster, clamp, out, out);
    else
        path.clamp(clamp, out, view.vertex_count);
}

BouncedLight::BouncedLight(const AssetView& of)
    : asset(&of), scores(of.model, of.model.indirect->clusters), mean(meansOf(of.model.indirect->clusters)) {}

void BouncedLight::evaluate(const EvaluatorPath& path, std::size_t cluster, std::span<float> indirect) const {
    assert(indirect.size() == asset->mesh.positions.size() * kIndirectStride);
    const std::size_t first = asset->model.clusters[cluster].first_vertex * kIndirectStride;
    scores.combine(path, cluster, noClamp(kIndirectStride), indirect.data() + first, mean->data() + first);
}

}  // namespace penumbra
