#include "player/frame/frame_values.h"

#include <algorithm>
#include <cmath>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

// Calls body(begin, end) for pieces of [0, vertices).
template <class Body>
void overVertices(std::size_t vertices, int threads, const Body& body) {
    constexpr std::size_t kPiece = 512;  // some 0.1 ms of shading
    parallelFor((vertices + kPiece - 1) / kPiece, threads,
                [&](std::size_t i) { body(i * kPiece, std::min(vertices, (i + 1) * kPiece)); });
}

}  // namespace

std::vector<float> truthCoefficients(const Shot& shot, const FrameVertices& vertices, int threads) {
    std::vector<float> coefficients(vertices.positions.size() * std::size_t(shot.asset->model.stride));
    overVertices(vertices.positions.size(), threads, [&](std::size_t begin, std::size_t end) {
        coefficientsFromTruth(*shot.truth, shot.truth_frame, *shot.asset, vertices.range(begin, end), coefficients);
    });
    return coefficients;
}

void skinFrame(const Evaluator& evaluator, int threads, FrameVertices& vertices) {
    const std::size_t count = evaluator.vertexCount();
    vertices.positions.resize(count);
    vertices.normals.resize(count);
    vertices.tangents.resize(count);
    overVertices(count, threads, [&](std::size_t begin, std::size_t end) {
        evaluator.skin(begin, end, vertices.positions, vertices.normals, vertices.tangents);
    });
}

namespace {

void evaluateClusters(const Evaluator& evaluator, int threads, const SkinnedVertices& skinned,
                      FrameVertices& vertices) {
    vertices.coefficients.resize(evaluator.vertexCount() * std::size_t(evaluator.asset().model.stride));
    parallelFor(evaluator.clusterCount(), threads,
                [&](std::size_t cluster) { evaluator.evaluateCluster(cluster, vertices.coefficients, skinned); });
    const std::size_t first = evaluator.firstFollower();
    overVertices(evaluator.vertexCount() - first, threads, [&](std::size_t begin, std::size_t end) {
        evaluator.follow(first + begin, first + end, {vertices.normals, vertices.tangents}, vertices.coefficients);
    });
}

}  // namespace

void evaluateCoefficients(const Evaluator& evaluator, int threads, FrameVertices& vertices) {
    evaluateClusters(evaluator, threads, {}, vertices);
}

void evaluateSkinned(const Evaluator& evaluator, int threads, FrameVertices& vertices) {
    evaluateClusters(evaluator, threads, {vertices.positions, vertices.normals, vertices.tangents}, vertices);
}

void evaluateIndirect(const Evaluator& evaluator, int threads, std::vector<float>& indirect) {
    if (!evaluator.hasIndirect()) return indirect.clear();
    indirect.resize(evaluator.vertexCount() * kIndirectStride);
    parallelFor(evaluator.clusterCount(), threads,
                [&](std::size_t cluster) { evaluator.evaluateIndirect(cluster, indirect); });
}

void evaluateFrame(const Shot& shot, VisibilitySource source, Evaluator& evaluator, int threads,
                   FrameVertices& vertices) {
    evaluator.setFrame(shot.frame);
    skinFrame(evaluator, threads, vertices);
    if (source == VisibilitySource::kModel)
        evaluateSkinned(evaluator, threads, vertices);
    else
        vertices.coefficients = truthCoefficients(shot, vertices, threads);
    evaluateIndirect(evaluator, threads, vertices.indirect);
}

std::vector<float> ambientOf(const Shot& shot, const std::vector<float>& coefficients, int threads) {
    const auto stride = std::size_t(shot.asset->model.stride);
    std::vector<float> e(coefficients.size() / stride);
    overVertices(e.size(), threads, [&](std::size_t begin, std::size_t end) {
        const std::size_t count = end - begin;
        ambient(*shot.asset, std::span(coefficients).subspan(begin * stride, count * stride),
                std::span(e).subspan(begin, count));
    });
    return e;
}

static void clampAtZero(std::span<Vec3> colors) {
    for (Vec3& color : colors) color = {std::max(color.x, 0.0f), std::max(color.y, 0.0f), std::max(color.z, 0.0f)};
}

void shadeFrame(const ShadingSet& shading, const FrameVertices& vertices, Vec3 eye, int threads,
                std::vector<Vec3>& radiance) {
    const std::size_t count = vertices.positions.size(), slopes = shading.surfaceTerms().slopes;
    radiance.resize(shading.terms() * count);
    const std::span<const std::uint32_t> order = shading.shadingOrder();
    overVertices(count, threads, [&](std::size_t begin, std::size_t end) {
        shading.shadeTerms(vertices.range(begin, end), eye, radiance);
        for (std::size_t term = 0; term < shading.terms(); term += term == 0 ? 1 + slopes : 1) {  // slopes have signs
            if (order.empty()) {
                clampAtZero(std::span(radiance).subspan(term * count + begin, end - begin));
                continue;
            }
            for (std::size_t at = begin; at < end; ++at)
                clampAtZero(std::span(radiance).subspan(term * count + order[at], 1));
        }
    });
}

void shadeSome(const ShadingSet& shading, std::span<const std::uint32_t> some, const FrameVertices& vertices, Vec3 eye,
               std::vector<Vec3>& radiance) {
    radiance.resize(vertices.positions.size());
    shading.shadeSome(some, vertices.range(0, radiance.size()), eye, radiance);
    for (const std::uint32_t v : some) clampAtZero(std::span(radiance).subspan(v, 1));
}

std::vector<std::uint32_t> clusterOfVertex(const AssetView& asset) {
    std::vector<std::uint32_t> cluster_of_vertex(asset.mesh.positions.size());
    for (std::size_t c = 0; c < asset.model.clusters.size(); ++c) {
        const ClusterView& cluster = asset.model.clusters[c];
        std::fill_n(cluster_of_vertex.begin() + cluster.first_vertex, cluster.vertex_count, std::uint32_t(c));
    }
    for (std::size_t v = asset.mesh.firstFollower(); v < cluster_of_vertex.size(); ++v)
        cluster_of_vertex[v] = cluster_of_vertex[asset.mesh.leaderOf(v)];
    return cluster_of_vertex;
}

std::vector<Vec3> channelValues(const Shot& shot, Channel channel, const ShadingSet* shading,
                                const FrameVertices& vertices, const std::vector<float>& true_ambient, Vec3 eye,
                                int threads) {
    if (channel == Channel::kNormals) return vertices.normals;
    std::vector<Vec3> values(vertices.positions.size());
    if (channel == Channel::kShaded) {
        shadeFrame(*shading, vertices, eye, threads, values);
        return values;
    }
    if (channel == Channel::kClusters) {
        const std::vector<std::uint32_t> cluster = clusterOfVertex(*shot.asset);
        for (std::size_t v = 0; v < values.size(); ++v) values[v].x = float(cluster[v]);
        return values;
    }
    if (channel == Channel::kParts) {
        const std::span<const std::uint16_t> part = shot.asset->model.composition->part_of_vertex;
        for (std::size_t v = 0; v < values.size(); ++v) values[v].x = float(part[v]);
        return values;
    }
    std::vector<float> e = ambientOf(shot, vertices.coefficients, threads);
    if (channel == Channel::kBouncedAmbient) addBouncedAmbient(shot.asset->model.indirect->axes, vertices.indirect, e);
    for (std::size_t v = 0; v < values.size(); ++v)
        values[v].x = channel == Channel::kError ? std::abs(e[v] - true_ambient[v]) : e[v];
    return values;
}

}  // namespace penumbra
