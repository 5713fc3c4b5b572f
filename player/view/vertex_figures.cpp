#include "player/view/vertex_figures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace penumbra {

VertexFigures figuresOf(const Character& character, std::size_t vertex) {
    const ModelView& model = character.asset.model;
    const std::size_t stride = std::size_t(model.stride), first = vertex * stride;
    const auto read = [&](const std::vector<float>& coefficients, std::span<const float>& figures, float& e) {
        figures = std::span(coefficients).subspan(first, std::size_t(model.convention.size()));
        ambient(character.asset, std::span(coefficients).subspan(first, stride), {&e, 1});
    };
    VertexFigures figures;
    figures.cluster = clusterAt(character.asset, vertex);
    figures.joint = character.asset.animation.joint_names[std::size_t(model.clusters[figures.cluster].joint)];
    figures.scores = character.posed.evaluator->scores(figures.cluster);
    if (character.posed.coefficients.key())
        read(character.posed.vertices.coefficients, figures.model, figures.model_ambient);
    if (*character.posed.truth_frame && character.posed.truth_coefficients.key())
        read(*character.posed.truth_coefficients, figures.truth, figures.true_ambient);
    return figures;
}

std::vector<float> componentAmbient(const ModelView& model, std::size_t vertices, std::size_t k) {
    std::vector<float> weights(std::size_t(model.convention.size())), e(vertices), basis;
    ambientWeights(model.convention, weights);
    const std::size_t stride = std::size_t(model.stride);
    for (const ClusterView& cluster : model.clusters) {
        if (k >= cluster.components()) continue;
        basis.resize(cluster.basis.count);
        decode(cluster.basis, basis);
        for (std::size_t v = 0; v < cluster.vertex_count; ++v)
            e[cluster.first_vertex + v] =
                std::inner_product(weights.begin(), weights.end(),
                                   basis.begin() + std::ptrdiff_t((k * cluster.vertex_count + v) * stride), 0.0f);
    }
    return e;
}

std::size_t mostComponents(const ModelView& model) {
    std::size_t most = 0;
    for (const ClusterView& cluster : model.clusters) most = std::max(most, cluster.components());
    return most;
}

Vec3 divergingColor(float value, float most) {
    const float t = most > 0 ? std::clamp(value / most, -1.0f, 1.0f) : 0;
    const Vec3 end = t < 0 ? Vec3{0.02f, 0.12f, 0.55f} : Vec3{0.6f, 0.03f, 0.03f};
    return Vec3{0.85f, 0.85f, 0.85f} * (1 - std::abs(t)) + end * std::abs(t);
}

}  // namespace penumbra
