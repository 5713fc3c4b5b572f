// Chooses anchors and weights at rest.
//
// Problem: sums over far parts vary slowly along the skin, but along the skin is not along the shortest way: the front
// and the back of a hand are near and see other things.
//
// Here: distances count the difference of normals too. Farthest-point sampling spreads the anchors of a part evenly in
// that distance. A vertex takes its 4 nearest ones, with weights that reach 0 where another anchor would come in.
#include "runtime/evaluate/far_anchors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "sh/character_box.h"
#include "sh/far/far_kernel.h"

namespace penumbra {

namespace {

// At full quality one vertex in 12 is an anchor. Of a coarse mesh it is one in 4, up to `coarse`.
struct AnchorCount {
    std::size_t vertices_of_anchor, coarse;
};
constexpr AnchorCount kAnchorCount[] = {{12, 800}, {28, 450}}, kCastAnchorCount = {12, 800};
constexpr std::size_t kVerticesOfCoarseAnchor = 4;
// A part with no more vertices has no anchors, nor one that sees no more far parts.
constexpr std::size_t kFewVertices = 64, kFewParts = 3;
// A larger cluster has no anchors for casts: choosing them takes time that grows with the square of its vertices.
constexpr std::uint32_t kMaxVertices = 50000;
// The difference of opposite normals counts as this share of the part's diagonal.
constexpr float kNormalShare = 0.4f;
// Regularises the anchor weights. A larger value spreads them more and reproduces linear functions less well.
constexpr double kSmoothness = 0.01;

// A place on the skin of a part.
struct Place {
    Vec3 position, normal;  // the normal in units of length
};
float squaredDistance(const Place& a, const Place& b) {
    const Vec3 p = a.position - b.position, n = a.normal - b.normal;
    return dot(p, p) + dot(n, n);
}

// Orders points along a curve that fills space, so that neighbours stand together (Morton order, 10 bits an axis).
std::uint32_t placeOnCurve(Vec3 point, const BoundingBox& box) {
    std::uint32_t place = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const float along = (point[axis] - box.low[axis]) / (box.high[axis] - box.low[axis]);
        const auto cell = along > 0 ? std::uint32_t(1023 * std::min(along, 1.0f)) : 0u;
        for (int bit = 0; bit < 10; ++bit) place |= (cell >> bit & 1) << (3 * bit + axis);
    }
    return place;
}

std::vector<std::uint32_t> sortedReceivers(const AssetView& asset, std::span<const std::uint16_t> part_of) {
    const BoundingBox box = characterBox(asset.mesh.frontTriangles(), asset.mesh.positions);
    using Key = std::tuple<std::uint16_t, std::uint32_t, std::uint32_t>;
    std::vector<std::uint32_t> receivers;
    for (const ClusterView& cluster : asset.model.clusters) {
        std::vector<Key> keys;
        for (std::uint32_t v = cluster.first_vertex; v < cluster.first_vertex + cluster.vertex_count; ++v)
            keys.emplace_back(part_of[v], placeOnCurve(asset.mesh.positions[v], box), v);
        std::sort(keys.begin(), keys.end());
        for (const Key& key : keys) receivers.push_back(std::get<2>(key));
    }
    return receivers;
}

// The anchors of one part.
struct PartAnchors {
    float normal_scale = 0;
    std::vector<std::uint32_t> vertices;  // vertices of the anchors
    std::vector<Place> places;            // places of the anchors
};

Place placeOf(const MeshView& mesh, std::uint32_t vertex, float normal_scale) {
    return {mesh.positions[vertex], mesh.normals[vertex] * normal_scale};
}

// Adds anchors to a part one by one, each where the vertices are farthest from all anchors so far.
class AnchorSampler {
public:
    AnchorSampler(const MeshView& mesh, const std::vector<std::uint32_t>& vertices)
        : mesh_(mesh), vertices_(vertices), gaps_(vertices.size(), std::numeric_limits<float>::max()) {
        std::vector<Vec3> positions;
        for (const std::uint32_t v : vertices) positions.push_back(mesh.positions[v]);
        anchors.normal_scale = kNormalShare * float(boundsOf(positions).radius());
        while (anchors.vertices.size() <= kAnchorsOfReceiver) add();
    }
    PartAnchors anchors;

    float gap() const { return gaps_[next_]; }  // squared
    void add() {
        const Place place = placeOf(mesh_, vertices_[next_], anchors.normal_scale);
        anchors.vertices.push_back(vertices_[next_]);
        anchors.places.push_back(place);
        for (std::size_t i = 0; i < vertices_.size(); ++i)
            gaps_[i] = std::min(gaps_[i], squaredDistance(place, placeOf(mesh_, vertices_[i], anchors.normal_scale)));
        next_ = std::size_t(std::max_element(gaps_.begin(), gaps_.end()) - gaps_.begin());
    }

private:
    const MeshView& mesh_;
    const std::vector<std::uint32_t>& vertices_;
    std::vector<float> gaps_;
    std::size_t next_ = 0;
};

// Chooses the anchors of all parts that `wanted` names. They are spread evenly over the skin: where vertices stand
// close, they share an anchor with more others.
std::vector<PartAnchors> chooseAnchors(const MeshView& mesh, const std::vector<std::vector<std::uint32_t>>& vertices,
                                       const std::vector<bool>& wanted, const AnchorCount& wanted_count) {
    std::vector<AnchorSampler> samplers;
    std::vector<std::size_t> part_of_sampler;
    std::size_t count = 0, chosen = 0;
    for (std::size_t p = 0; p < vertices.size(); ++p) {
        if (!wanted[p] || vertices[p].size() <= kFewVertices) continue;
        part_of_sampler.push_back(p);
        samplers.emplace_back(mesh, vertices[p]);
        count += vertices[p].size();
        chosen += samplers.back().anchors.vertices.size();
    }
    count = std::max(count / wanted_count.vertices_of_anchor,
                     std::min(count / kVerticesOfCoarseAnchor, wanted_count.coarse));
    for (; chosen < count; ++chosen)
        std::max_element(samplers.begin(), samplers.end(), [](const AnchorSampler& a, const AnchorSampler& b) {
            return a.gap() < b.gap();
        })->add();
    std::vector<PartAnchors> anchors(vertices.size());
    for (std::size_t i = 0; i < samplers.size(); ++i) anchors[part_of_sampler[i]] = std::move(samplers[i].anchors);
    return anchors;
}

// The nearest anchors of a vertex, index into the part's, and their weights.
struct Nearest {
    std::array<std::size_t, kAnchorsOfReceiver> anchor{};
    std::array<float, kAnchorsOfReceiver> weight{};
};

// Solves A x = b for a symmetric positive definite A, by elimination without pivots.
template <std::size_t N>
std::array<double, N> solve(std::array<std::array<double, N>, N> a, std::array<double, N> b) {
    for (std::size_t k = 0; k < N; ++k)
        for (std::size_t i = k + 1; i < N; ++i) {
            const double share = a[i][k] / a[k][k];
            for (std::size_t j = k; j < N; ++j) a[i][j] -= share * a[k][j];
            b[i] -= share * b[k];
        }
    for (std::size_t k = N; k-- > 0;) {
        for (std::size_t j = k + 1; j < N; ++j) b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
    return b;
}

// Weights that give back functions that are constant exactly and linear ones nearly, with the smallest that do so. A
// weight costs more the farther its anchor is and reaches 0 where another anchor would come in, so that neighbours have
// nearly the same weights. With x_i the anchors' places as seen from the vertex, in units of `reach`, the weights
// minimise |sum w_i x_i|^2 + sum c_i w_i^2, sum w_i = 1.
Nearest nearestAnchors(const PartAnchors& part, const Place& place) {
    std::array<std::pair<float, std::size_t>, kAnchorsOfReceiver + 1> best;
    best.fill({std::numeric_limits<float>::max(), 0});
    for (std::size_t a = 0; a < part.places.size(); ++a) {
        const std::pair<float, std::size_t> candidate{std::sqrt(squaredDistance(part.places[a], place)), a};
        if (!(candidate < best.back())) continue;
        best.back() = candidate;
        std::sort(best.begin(), best.end());
    }
    const float reach = std::max(best.back().first, std::numeric_limits<float>::min());
    std::array<Place, kAnchorsOfReceiver> offset;
    std::array<std::array<double, kAnchorsOfReceiver>, kAnchorsOfReceiver> a;
    for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
        const Place& anchor = part.places[best[i].second];
        offset[i] = {(anchor.position - place.position) / reach, (anchor.normal - place.normal) / reach};
    }
    for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
        for (std::size_t j = 0; j < kAnchorsOfReceiver; ++j)
            a[i][j] = dot(offset[i].position, offset[j].position) + dot(offset[i].normal, offset[j].normal);
        const double d = best[i].first / reach, left = std::max(1 - d, 1e-3);
        a[i][i] += kSmoothness * (0.01 + d * d) / (left * left);
    }
    // The minimum under sum w_i = 1 is A^-1 1, scaled.
    std::array<double, kAnchorsOfReceiver> ones;
    ones.fill(1);
    const std::array<double, kAnchorsOfReceiver> weights = solve(a, ones);
    double sum = 0;
    for (const double w : weights) sum += w;
    Nearest nearest;
    for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
        nearest.anchor[i] = best[i].second;
        nearest.weight[i] = float(weights[i] / sum);
    }
    return nearest;
}

// Fills in the anchors of a run's receivers.
void addAnchors(const MeshView& mesh, const PartAnchors& part, std::size_t part_count, FarRun& run, FarLayout& layout) {
    run.first_anchor = std::uint32_t(layout.anchors.size());
    std::map<std::size_t, std::uint16_t> place;
    float distances = 0;
    for (std::uint32_t r = run.first; r < run.first + run.count; ++r) {
        const Nearest nearest = nearestAnchors(part, placeOf(mesh, layout.receivers[r], part.normal_scale));
        for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
            const auto [found, fresh] = place.emplace(nearest.anchor[i], std::uint16_t(place.size()));
            if (fresh) layout.anchors.push_back(part.vertices[nearest.anchor[i]]);
            layout.anchor[r * kAnchorsOfReceiver + i] = found->second;
            layout.weight[r * kAnchorsOfReceiver + i] = nearest.weight[i];
            distances += length(mesh.positions[layout.receivers[r]] - part.places[nearest.anchor[i]].position);
        }
    }
    run.spacing = distances / float(run.count * kAnchorsOfReceiver);
    run.anchor_count = std::uint32_t(place.size());
    run.first_value = layout.values;
    layout.values += run.anchor_count * anchorStride(part_count);
}

// Lays out the vertices of an asset. Parts that are wanted have anchors.
FarLayout layOut(const AssetView& asset, std::span<const std::uint16_t> part_of,
                 const std::vector<std::size_t>& part_counts, const std::vector<bool>& wanted,
                 const AnchorCount& wanted_count) {
    FarLayout layout;
    layout.receivers = sortedReceivers(asset, part_of);
    layout.anchor.resize(layout.receivers.size() * kAnchorsOfReceiver);
    layout.weight.resize(layout.anchor.size());
    // 1. Anchors of every part, whatever its clusters are.
    std::vector<std::vector<std::uint32_t>> vertices(part_counts.size());
    for (std::uint32_t v = 0; v < asset.mesh.firstFollower(); ++v) vertices[part_of[v]].push_back(v);
    const std::vector<PartAnchors> anchors = chooseAnchors(asset.mesh, vertices, wanted, wanted_count);
    // 2. Runs.
    for (const ClusterView& cluster : asset.model.clusters) {
        layout.first_run.push_back(std::uint32_t(layout.runs.size()));
        const std::uint32_t end = cluster.first_vertex + cluster.vertex_count;
        for (std::uint32_t r = cluster.first_vertex; r < end;) {
            FarRun run;
            run.part = part_of[layout.receivers[r]];
            run.first = r;
            while (r < end && part_of[layout.receivers[r]] == run.part) ++r;
            run.count = r - run.first;
            if (!anchors[run.part].vertices.empty())
                addAnchors(asset.mesh, anchors[run.part], part_counts[run.part], run, layout);
            layout.runs.push_back(run);
        }
    }
    layout.first_run.push_back(std::uint32_t(layout.runs.size()));
    return layout;
}

}  // namespace

FarTables makeFarTables(const CompositionView& composition, int order) {
    FarFields fields;
    for (const PartFieldView& part : composition.parts) {
        fields.tables.push_back(makeFieldTable(part.field, part.bytes, composition.fade));
        fields.joints.push_back(part.field.joint);
    }
    fields.floor = composition.floor;
    auto far = farParts(composition.steps, composition.parts.size(), composition.local_steps);
    return {std::move(fields),
            std::move(far),
            order,
            {composition.near_count, {composition.near_parts.begin(), composition.near_parts.end()}}};
}

FarLayout makeFarLayout(const AssetView& asset, const std::vector<std::size_t>& part_counts, FarQuality quality) {
    std::vector<bool> wanted;
    for (const std::size_t count : part_counts) wanted.push_back(count > kFewParts && count <= kMaxAnchorParts);
    return layOut(asset, asset.model.composition->part_of_vertex, part_counts, wanted,
                  kAnchorCount[std::size_t(quality)]);
}

FarLayout makeCastLayout(const AssetView& asset) {
    const std::size_t clusters = asset.model.clusters.size();
    std::vector<std::uint16_t> cluster_of(asset.mesh.positions.size());
    std::vector<bool> wanted;
    for (std::size_t c = 0; c < clusters; ++c) {
        const ClusterView& cluster = asset.model.clusters[c];
        std::fill_n(cluster_of.begin() + cluster.first_vertex, cluster.vertex_count, std::uint16_t(c));
        wanted.push_back(cluster.vertex_count <= kMaxVertices);
    }
    return layOut(asset, cluster_of, std::vector<std::size_t>(clusters), wanted, kCastAnchorCount);
}

}  // namespace penumbra
