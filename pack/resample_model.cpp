#include "pack/resample_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "pack/border_corners.h"
#include "sh/indirect_coefficients.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

// Returns the cluster that most of the vertex' points have, by weight; of equal ones the first.
std::uint32_t clusterOf(const Model& fitted, const PointTable& points, std::size_t v) {
    std::map<std::uint32_t, float> weights;
    for (std::size_t i = 0; i < 3; ++i) weights[fitted.cluster_of_vertex[points.corners[v][i]]] += points.weights[v][i];
    return std::max_element(weights.begin(), weights.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
}

// What every vertex takes, and from whom.
struct Sources {
    const Model& fitted;
    const DrawnMesh& drawn;
    std::vector<std::uint32_t> cluster;  // [W]
    std::vector<Vec3> tangents;          // [W] at rest
    std::vector<std::uint32_t> place;    // [V] in the vertices of its cluster
    std::vector<BorderCorner> border;    // sorted
    BorderRows border_rows;
};

Vec3 tangentOfVertex(const Model& fitted, const DrawnMesh& drawn, std::uint32_t cluster, std::size_t v) {
    Vec3 sum;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t corner = drawn.points.corners[v][i];
        if (fitted.cluster_of_vertex[corner] != cluster) continue;
        sum += carriedTangent(fitted.rest_normals[corner], drawn.rest_normals[v], fitted.rest_tangents[corner]) *
               drawn.points.weights[v][i];
    }
    return tangentOf(drawn.rest_normals[v], sum);
}

Sources sourcesOf(const Model& fitted, const DrawnMesh& drawn, int threads) {
    Sources sources{fitted, drawn, {}, {}, std::vector<std::uint32_t>(fitted.mesh.vertexCount()), {}, {}};
    for (const ClusterModel& cluster : fitted.clusters)
        for (std::size_t i = 0; i < cluster.vertices.size(); ++i) sources.place[cluster.vertices[i]] = std::uint32_t(i);
    for (std::size_t v = 0; v < drawn.mesh.vertexCount(); ++v) {
        const std::uint32_t cluster = clusterOf(fitted, drawn.points, v);
        sources.cluster.push_back(cluster);
        sources.tangents.push_back(tangentOfVertex(fitted, drawn, cluster, v));
        for (std::size_t i = 0; i < 3; ++i)
            if (const std::uint32_t corner = drawn.points.corners[v][i];
                drawn.points.weights[v][i] > 0 && fitted.cluster_of_vertex[corner] != cluster)
                sources.border.push_back({cluster, corner});
    }
    std::sort(sources.border.begin(), sources.border.end());
    sources.border.erase(std::unique(sources.border.begin(), sources.border.end()), sources.border.end());
    sources.border_rows = borderRows(fitted, sources.border, threads);
    return sources;
}

// Returns the row `k` of a vertex of the fitted mesh in a cluster: 0 is the mean, k + 1 is component k.
std::span<const float> rowOfVertex(const Sources& sources, std::size_t list, BorderCorner corner, std::size_t k) {
    const std::size_t n = list == 2 ? kIndirectSize : std::size_t(sources.fitted.convention.size());
    if (sources.fitted.cluster_of_vertex[corner.vertex] != corner.cluster) {
        const auto found = std::lower_bound(sources.border.begin(), sources.border.end(), corner);
        return std::span(sources.border_rows[list][std::size_t(found - sources.border.begin())]).subspan(k * n, n);
    }
    const ClusterModel& cluster = (*clusterLists(sources.fitted)[list])[corner.cluster];
    const std::size_t at = sources.place[corner.vertex];
    if (k == 0) return std::span(cluster.mean).subspan(at * n, n);
    return std::span(cluster.basis).subspan(((k - 1) * cluster.vertices.size() + at) * n, n);
}

// Fills in the mean and the components of the vertices of a cluster.
void fillCluster(const Sources& sources, std::size_t list, const TurnTable& turns, ClusterModel& cluster,
                 std::uint32_t index) {
    const std::size_t n = turns.size(), count = cluster.vertices.size(), components = cluster.components();
    cluster.mean.assign(count * n, 0);
    cluster.basis.assign(components * count * n, 0);
    std::vector<float> turned(n);
    const DrawnMesh& drawn = sources.drawn;
    for (std::size_t at = 0; at < count; ++at) {
        const std::uint32_t v = cluster.vertices[at];
        for (std::size_t i = 0; i < 3; ++i) {
            const float weight = drawn.points.weights[v][i];
            if (weight == 0) continue;
            const std::uint32_t corner = drawn.points.corners[v][i];
            const Vec3 normal = drawn.rest_normals[v];
            const Vec3 tangent =
                carriedTangent(sources.fitted.rest_normals[corner], normal, sources.fitted.rest_tangents[corner]);
            const FrameTurn turn = makeTurn(turns, angleBetween(normal, tangent, sources.tangents[v]));
            for (std::size_t k = 0; k <= components; ++k) {
                apply(turn, rowOfVertex(sources, list, {index, corner}, k), turned);
                float* out = k == 0 ? &cluster.mean[at * n] : &cluster.basis[((k - 1) * count + at) * n];
                for (std::size_t j = 0; j < n; ++j) out[j] += weight * turned[j];
            }
        }
    }
}

// Replaces the vertices of a list of clusters. Those that nothing is left of are dropped.
void fillClusters(const Sources& sources, std::size_t list, const std::vector<std::vector<std::uint32_t>>& vertices,
                  int threads, std::vector<ClusterModel>& clusters) {
    const TurnTable turns = turnsOfLists(sources.fitted)[list];
    parallelFor(clusters.size(), threads, [&](std::size_t c) {
        clusters[c].vertices = vertices[c];
        fillCluster(sources, list, turns, clusters[c], std::uint32_t(c));
    });
    std::erase_if(clusters, [](const ClusterModel& cluster) { return cluster.vertices.empty(); });
}

// Returns the gain of a vertex of the fitted mesh for a part, whatever its own part is: a far part counts in full. A
// vertex to which the part is neither near nor far cannot say.
std::optional<float> gainFor(const Composition& fitted, std::uint32_t vertex, std::uint16_t part) {
    const std::size_t columns = fitted.near_count, own = fitted.part_of_vertex[vertex];
    for (std::size_t n = 0; n < columns; ++n)
        if (fitted.near_parts[own * columns + n] == part) return float(fitted.near_gains[vertex * columns + n]);
    if (int(fitted.steps[own * fitted.fields.parts.size() + part]) > fitted.local_steps) return 1 / kPerGain;
    return std::nullopt;
}

// Interpolates the gains of a vertex of `own_part` between the points that can say, and adds them to `out`.
void addGains(const Composition& fitted, const PointTable& points, std::size_t v, std::uint16_t own_part,
              std::vector<std::uint8_t>& out) {
    for (std::size_t n = 0; n < fitted.near_count; ++n) {
        const std::uint16_t part = fitted.near_parts[own_part * fitted.near_count + n];
        float sum = 0, weights = 0;
        for (std::size_t i = 0; i < 3 && part != kNoPart; ++i)
            if (const std::optional<float> gain = gainFor(fitted, points.corners[v][i], part)) {
                sum += points.weights[v][i] * *gain;
                weights += points.weights[v][i];
            }
        out.push_back(weights > 0 ? std::uint8_t(std::lround(sum / weights)) : std::uint8_t(0));
    }
}

void replaceMesh(const DrawnMesh& drawn, const std::vector<Vec3>& tangents, Model& model) {
    model.mesh = drawn.mesh;
    model.drawn.reset();
    model.skin.influences = drawn.skin.influences;
    model.skin.joints = drawn.skin.joints;
    model.skin.weights = drawn.skin.weights;
    model.rest_normals = drawn.rest_normals;
    model.rest_tangents = tangents;
    if (!model.composition) return;
    const Composition fitted = *model.composition;
    Composition& composition = *model.composition;
    composition.part_of_vertex.clear();
    composition.near_gains.clear();
    for (std::size_t v = 0; v < drawn.mesh.vertexCount(); ++v) {
        const auto& weights = drawn.points.weights[v];
        const auto most = std::size_t(std::max_element(weights.begin(), weights.end()) - weights.begin());
        composition.part_of_vertex.push_back(fitted.part_of_vertex[drawn.points.corners[v][most]]);
        addGains(fitted, drawn.points, v, composition.part_of_vertex.back(), composition.near_gains);
    }
}

}  // namespace

Resampled resampledModel(const Model& fitted, const DrawnMesh& drawn, int threads) {
    if (fitted.deforming)
        throw Unsupported("the model is of a mesh without a skeleton, which no other mesh can follow");
    const Sources sources = sourcesOf(fitted, drawn, threads);
    std::vector<std::vector<std::uint32_t>> vertices(fitted.clusters.size());
    for (std::size_t v = 0; v < sources.cluster.size(); ++v) vertices[sources.cluster[v]].push_back(std::uint32_t(v));
    Resampled out{fitted, sources.border.size()};
    Model& model = out.model;
    replaceMesh(drawn, sources.tangents, model);
    fillClusters(sources, 0, vertices, threads, model.clusters);
    if (model.composition && !model.composition->residual.empty())
        fillClusters(sources, 1, vertices, threads, model.composition->residual);
    if (model.indirect) fillClusters(sources, 2, vertices, threads, model.indirect->clusters);
    model.cluster_of_vertex.assign(drawn.mesh.vertexCount(), 0);
    for (std::size_t c = 0; c < model.clusters.size(); ++c)
        for (const std::uint32_t v : model.clusters[c].vertices) model.cluster_of_vertex[v] = std::uint32_t(c);
    return out;
}

}  // namespace penumbra
