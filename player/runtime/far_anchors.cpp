// Chooses anchors and weights at rest.
//
// Problem: sums over far parts vary slowly along the skin, but along the skin is not along the shortest way: the front
// and the back of a hand are near and see other things.
//
// Here: distances count the difference of normals too. Farthest-point sampling spreads the anchors of a part evenly in
// that distance. A vertex takes its 4 nearest ones, with weights that reach 0 where another anchor would come in.
#include "player/runtime/far_anchors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

#include "player/runtime/far_kernel.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr std::size_t kVerticesOfAnchor = 12, kMostAnchors = 2048;  // of a part
constexpr std::size_t kFewVertices = 64;                            // a part with no more has no anchors
// The difference of opposite normals counts as this share of the part's diagonal.
constexpr float kNormalShare = 0.5f;

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

std::vector<std::uint32_t> sortedReceivers(const AssetView& asset) {
    const BoundingBox box = boundsOf(asset.mesh.positions);
    const std::span<const std::uint16_t> part_of = asset.model.composition->part_of_vertex;
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

// The anchors of one part, and the places of all of its vertices.
struct PartAnchors {
    float normal_scale = 0;
    std::vector<std::uint32_t> vertices;  // of the anchors
    std::vector<Place> places;            // of the anchors
};

Place placeOf(const MeshView& mesh, std::uint32_t vertex, float normal_scale) {
    return {mesh.positions[vertex], mesh.normals[vertex] * normal_scale};
}

PartAnchors chooseAnchors(const MeshView& mesh, const std::vector<std::uint32_t>& vertices) {
    PartAnchors chosen;
    if (vertices.size() <= kFewVertices) return chosen;
    std::vector<Vec3> positions;
    for (const std::uint32_t v : vertices) positions.push_back(mesh.positions[v]);
    chosen.normal_scale = kNormalShare * float(boundsOf(positions).radius());
    std::vector<float> distance(vertices.size(), std::numeric_limits<float>::max());
    const std::size_t count = std::min((vertices.size() + kVerticesOfAnchor - 1) / kVerticesOfAnchor, kMostAnchors);
    std::size_t next = 0;
    while (chosen.vertices.size() < count) {
        chosen.vertices.push_back(vertices[next]);
        chosen.places.push_back(placeOf(mesh, vertices[next], chosen.normal_scale));
        for (std::size_t i = 0; i < vertices.size(); ++i)
            distance[i] = std::min(
                distance[i], squaredDistance(chosen.places.back(), placeOf(mesh, vertices[i], chosen.normal_scale)));
        next = std::size_t(std::max_element(distance.begin(), distance.end()) - distance.begin());
    }
    return chosen;
}

// The nearest anchors of a vertex, index into the part's, and their weights.
struct Nearest {
    std::array<std::size_t, kAnchorsOfReceiver> anchor{};
    std::array<float, kAnchorsOfReceiver> weight{};
};

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
    Nearest nearest;
    float sum = 0;
    for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
        const float d = best[i].first / reach, weight = (1 - d) / (d + 0.1f);
        nearest.anchor[i] = best[i].second;
        nearest.weight[i] = d < 1 ? weight * weight : 0;
        sum += nearest.weight[i];
    }
    if (!(sum > 0)) nearest.weight[0] = sum = 1;
    for (float& weight : nearest.weight) weight /= sum;
    return nearest;
}

// Fills in the anchors of a run's receivers.
void addAnchors(const MeshView& mesh, const PartAnchors& part, std::size_t part_count, FarRun& run, FarLayout& layout) {
    run.first_anchor = std::uint32_t(layout.anchors.size());
    std::map<std::size_t, std::uint16_t> place;
    for (std::uint32_t r = run.first; r < run.first + run.count; ++r) {
        const Nearest nearest = nearestAnchors(part, placeOf(mesh, layout.receivers[r], part.normal_scale));
        for (std::size_t i = 0; i < kAnchorsOfReceiver; ++i) {
            const auto [found, fresh] = place.emplace(nearest.anchor[i], std::uint16_t(place.size()));
            if (fresh) layout.anchors.push_back(part.vertices[nearest.anchor[i]]);
            layout.anchor[r * kAnchorsOfReceiver + i] = found->second;
            layout.weight[r * kAnchorsOfReceiver + i] = nearest.weight[i];
        }
    }
    run.anchor_count = std::uint32_t(place.size());
    run.first_value = layout.values;
    layout.values += run.anchor_count * anchorStride(part_count);
}

}  // namespace

FarLayout makeFarLayout(const AssetView& asset, const std::vector<std::size_t>& part_counts) {
    const std::span<const std::uint16_t> part_of = asset.model.composition->part_of_vertex;
    FarLayout layout;
    layout.receivers = sortedReceivers(asset);
    layout.anchor.resize(layout.receivers.size() * kAnchorsOfReceiver);
    layout.weight.resize(layout.anchor.size());
    // 1. Anchors of every part, whatever its clusters are.
    std::vector<std::vector<std::uint32_t>> vertices(part_counts.size());
    for (std::uint32_t v = 0; v < part_of.size(); ++v) vertices[part_of[v]].push_back(v);
    std::vector<PartAnchors> anchors(part_counts.size());
    for (std::size_t p = 0; p < vertices.size(); ++p)
        if (part_counts[p] > 0 && part_counts[p] <= kMostAnchorParts)
            anchors[p] = chooseAnchors(asset.mesh, vertices[p]);
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

}  // namespace penumbra
