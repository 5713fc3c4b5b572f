#include "player/view/vertex_figures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace penumbra {

namespace {

float ambientOfVertex(const AssetView& asset, std::span<const float> numbers) {
    float e = 0;
    if (asset.transfer)
        transferAmbient(int(numbers.size()), numbers, {&e, 1});
    else
        ambient(asset.model.convention, int(numbers.size()), numbers, {&e, 1});
    return e;
}

}  // namespace

VertexFigures figuresOf(const Character& character, std::size_t vertex) {
    const ModelView& model = character.asset.model;
    const std::size_t first = vertex * std::size_t(model.stride), size = std::size_t(model.convention.size());
    VertexFigures figures;
    figures.cluster = clusterAt(character.asset, vertex);
    figures.joint = character.asset.animation.joint_names[std::size_t(model.clusters[figures.cluster].joint)];
    figures.scores = character.posed.evaluator->scores(figures.cluster);
    if (character.posed.numbers.key()) {
        figures.model = std::span(character.posed.vertices.numbers).subspan(first, size);
        figures.model_ambient = ambientOfVertex(character.asset, figures.model);
    }
    if (*character.posed.truth_frame && character.posed.truth_numbers.key()) {
        figures.truth = std::span(*character.posed.truth_numbers).subspan(first, size);
        figures.true_ambient = ambientOfVertex(character.asset, figures.truth);
    }
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
