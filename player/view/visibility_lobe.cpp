#include "player/view/visibility_lobe.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace penumbra {

// An even number, so that a ring lies in the tangent plane.
constexpr int kLobeRings = 32;

Shape visibilityLobe(const Convention& convention, std::span<const float> numbers, const Mat3& local_frame, Vec3 center,
                     float scale) {
    std::vector<float> coefficients(std::size_t(coefficientCount(convention.order))), basis(coefficients.size());
    toCoefficients(convention, numbers, coefficients);
    const Mat3 model_from_local = transposed(local_frame);
    Shape lobe = unitSphere(kLobeRings);
    for (Vec3& p : lobe.positions) {
        const Vec3 direction{p.z, p.x, p.y};  // local: the sphere's pole is the normal
        evalBasis(convention.order, direction, basis);
        const float v = std::inner_product(basis.begin(), basis.end(), coefficients.begin(), 0.0f);
        const bool above = direction.z >= -1e-6f;
        lobe.values.push_back({above ? v : 0, 0, 0});
        p = center + model_from_local * direction * (above ? scale * std::max(v, 0.0f) : 0);
    }
    return lobe;
}

void shadeLobe(Shape& lobe, Vec3 eye) {
    std::vector<Vec3> normals(lobe.positions.size());  // not unit: sums of twice the triangles' areas
    for (std::size_t t = 0; t < lobe.triangles.size(); t += 3) {
        const std::uint32_t a = lobe.triangles[t], b = lobe.triangles[t + 1], c = lobe.triangles[t + 2];
        const Vec3 n = cross(lobe.positions[b] - lobe.positions[a], lobe.positions[c] - lobe.positions[a]);
        for (const std::uint32_t i : {a, b, c}) normals[i] += n;
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const float facing = std::abs(dot(normalized(normals[i]), normalized(eye - lobe.positions[i])));
        const float v = std::clamp(lobe.values[i].x, 0.0f, 1.0f);
        lobe.values[i] =
            (Vec3{0.03f, 0.08f, 0.5f} * (1 - v) + Vec3{1, 0.75f, 0.1f} * v) * (0.15f + 0.85f * facing * facing);
    }
}

std::size_t clusterAt(const ModelView& model, std::size_t vertex) {
    std::size_t c = 0;
    while (vertex >= model.clusters[c].first_vertex + model.clusters[c].vertex_count) ++c;
    return c;
}

namespace {

float ambientOfVertex(const Convention& convention, std::span<const float> numbers) {
    std::vector<float> weights(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    return std::inner_product(weights.begin(), weights.end(), numbers.begin(), 0.0f);
}

}  // namespace

VertexFigures figuresOf(const Character& character, std::size_t vertex) {
    const ModelView& model = character.asset.model;
    const std::size_t first = vertex * std::size_t(model.stride), size = std::size_t(model.convention.size());
    VertexFigures figures;
    figures.cluster = clusterAt(model, vertex);
    figures.joint = character.asset.animation.joint_names[std::size_t(model.clusters[figures.cluster].joint)];
    figures.scores = character.evaluator->scores(figures.cluster);
    if (character.has_model_numbers) {
        figures.model = std::span(character.vertices.numbers).subspan(first, size);
        figures.model_ambient = ambientOfVertex(model.convention, figures.model);
    }
    if (character.has_truth_numbers) {
        figures.truth = std::span(character.truth_numbers).subspan(first, size);
        figures.true_ambient = ambientOfVertex(model.convention, figures.truth);
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
