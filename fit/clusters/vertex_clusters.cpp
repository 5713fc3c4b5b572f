// Clusters vertices that move alike, to a given number of clusters.
//
// Problem: a model of the pose is fitted for each cluster, so the vertices of a cluster should follow the same bones
// and lie together, and the user wants to choose how many clusters there are.
//
// Naive: k-means on the skinning weights takes a number but depends on its start, and it cannot split vertices that all
// follow one bone.
//
// Here: mean-shift finds the groups that are there (mean_shift.cpp). Ward's rule merges groups down to the number, and
// cuts in space bring them up to it. The steps are numbered in vertex_clusters.h. See docs/formulas.md, section 4.

#include "fit/clusters/vertex_clusters.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "fit/clusters/mean_shift.h"
#include "fit/numerics/pca.h"

namespace penumbra {

namespace {

// A cluster in the making, with the sums that its means come from.
struct Group {
    std::vector<std::uint32_t> vertices;
    std::vector<double> weight_sum;  // [J] sum of the vertices' weights
    Vec3d place_sum;                 // sum of their rest positions
};

// The vertices from which clusters are made. With `parts`, groups are compared by place and not by weights.
struct Source {
    const Mesh& mesh;
    const Skin& skin;
    bool parts = false;
};

Group makeGroup(const Source& source, std::vector<std::uint32_t> vertices) {
    const Skin& skin = source.skin;
    Group group{std::move(vertices), std::vector<double>(skin.jointCount()), {}};
    for (std::uint32_t v : group.vertices) group.place_sum += toDouble(source.mesh.rest_positions[v]);
    for (std::uint32_t v : group.vertices)
        for (int k = 0; k < skin.influences; ++k) {
            const std::size_t i = std::size_t(v) * std::size_t(skin.influences) + std::size_t(k);
            group.weight_sum[skin.joints[i]] += skin.weights[i];
        }
    return group;
}

// Returns the squared distance between the mean weights (or mean places) of two groups.
double squaredGroupDistance(const Source& source, const Group& a, const Group& b) {
    if (source.parts) {
        const Vec3d d = a.place_sum / double(a.vertices.size()) - b.place_sum / double(b.vertices.size());
        return dot(d, d);
    }
    double sum = 0;
    for (std::size_t j = 0; j < a.weight_sum.size(); ++j) {
        const double d = a.weight_sum[j] / double(a.vertices.size()) - b.weight_sum[j] / double(b.vertices.size());
        sum += d * d;
    }
    return sum;
}

// Returns what a union adds to the sum of squared distances from the mean.
double wardCost(const Source& source, const Group& a, const Group& b) {
    const double na = double(a.vertices.size()), nb = double(b.vertices.size());
    return na * nb / (na + nb) * squaredGroupDistance(source, a, b);
}

void mergeInto(std::vector<Group>& groups, std::size_t target, std::size_t source) {
    std::vector<std::uint32_t>& vertices = groups[target].vertices;
    vertices.insert(vertices.end(), groups[source].vertices.begin(), groups[source].vertices.end());
    for (std::size_t j = 0; j < groups[target].weight_sum.size(); ++j)
        groups[target].weight_sum[j] += groups[source].weight_sum[j];
    groups[target].place_sum += groups[source].place_sum;
    groups.erase(groups.begin() + std::ptrdiff_t(source));
}

// Step 2: joins groups of fewer than `least` vertices to the nearest group, the smallest first.
void mergeTiny(const Source& by, std::vector<Group>& groups, std::size_t least) {
    while (groups.size() > 1) {
        const auto smallest = std::min_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
            return a.vertices.size() < b.vertices.size();
        });
        if (smallest->vertices.size() >= least) return;
        const std::size_t source = std::size_t(smallest - groups.begin());
        std::size_t nearest = source == 0 ? 1 : 0;
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (g != source && squaredGroupDistance(by, groups[g], groups[source]) <
                                   squaredGroupDistance(by, groups[nearest], groups[source]))
                nearest = g;
        mergeInto(groups, nearest, source);
    }
}

// Step 3: merges the cheapest pair until `count` groups are left.
void mergeDownTo(const Source& by, std::vector<Group>& groups, std::size_t count) {
    while (groups.size() > count) {
        std::size_t target = 0, source = 1;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t a = 0; a < groups.size(); ++a)
            for (std::size_t b = a + 1; b < groups.size(); ++b)
                if (const double cost = wardCost(by, groups[a], groups[b]); cost < least) {
                    least = cost;
                    target = a;
                    source = b;
                }
        mergeInto(groups, target, source);
    }
}

// Cuts a group at the median along its longest principal axis. Vertices with equal projections are ordered by number.
void splitGroup(const Source& source, std::vector<Group>& groups, std::size_t largest) {
    const Mesh& mesh = source.mesh;
    std::vector<std::uint32_t> order = groups[largest].vertices;
    std::vector<Vec3> points;
    for (std::uint32_t v : order) points.push_back(mesh.rest_positions[v]);
    const Vec3d axis = principalAxes(points)[0];
    const auto along = [&](std::uint32_t v) { return dot(toDouble(mesh.rest_positions[v]), axis); };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(along(a), a) < std::pair(along(b), b); });
    const auto middle = order.begin() + std::ptrdiff_t(order.size() / 2);
    groups[largest] = makeGroup(source, {order.begin(), middle});
    groups.push_back(makeGroup(source, {middle, order.end()}));
}

// Step 4: cuts the largest group until there are `count`.
void splitUpTo(const Source& source, std::vector<Group>& groups, std::size_t count) {
    while (groups.size() < count) {
        const auto largest = std::max_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
            return a.vertices.size() < b.vertices.size();
        });
        assert(largest->vertices.size() > 1);
        splitGroup(source, groups, std::size_t(largest - groups.begin()));
    }
}

// Orders the groups by their first vertex and finds the joint of each.
VertexClusters numberGroups(std::vector<Group> groups, std::size_t vertex_count) {
    for (Group& group : groups) std::sort(group.vertices.begin(), group.vertices.end());
    std::sort(groups.begin(), groups.end(),
              [](const Group& a, const Group& b) { return a.vertices.front() < b.vertices.front(); });
    VertexClusters clusters;
    clusters.cluster_of_vertex.resize(vertex_count);
    for (Group& group : groups) {
        for (std::uint32_t v : group.vertices) clusters.cluster_of_vertex[v] = std::uint32_t(clusters.vertices.size());
        const auto heaviest = std::max_element(group.weight_sum.begin(), group.weight_sum.end());
        clusters.joint.push_back(int(heaviest - group.weight_sum.begin()));
        clusters.vertices.push_back(std::move(group.vertices));
    }
    return clusters;
}

std::vector<Group> groupsOf(const Source& source, const std::vector<std::uint32_t>& labels) {
    std::vector<std::vector<std::uint32_t>> members(1 + *std::max_element(labels.begin(), labels.end()));
    for (std::size_t v = 0; v < labels.size(); ++v) members[labels[v]].push_back(std::uint32_t(v));
    std::vector<Group> groups;
    for (auto& vertices : members)
        if (!vertices.empty()) groups.push_back(makeGroup(source, std::move(vertices)));
    return groups;
}

// Runs steps 2 to 4 on groups of `vertices` vertices in all.
std::vector<Group> mergedOrSplit(const Source& source, std::vector<Group> groups, std::size_t vertices,
                                 std::size_t count) {
    mergeTiny(source, groups, vertices / 1000);
    if (count == 0) count = std::max(groups.size(), (vertices + kAutoClusterSize - 1) / kAutoClusterSize);
    mergeDownTo(source, groups, count);
    splitUpTo(source, groups, count);
    return groups;
}

}  // namespace

VertexClusters clusterVertices(const Mesh& mesh, const Skin& skin, std::size_t count, int threads) {
    assert(count <= mesh.vertexCount());
    const Source source{mesh, skin, false};
    const std::vector<std::uint32_t> labels = meanShiftSkinWeights(skin, kSkinWeightBandwidth, threads);
    return numberGroups(mergedOrSplit(source, groupsOf(source, labels), mesh.vertexCount(), count), mesh.vertexCount());
}

VertexClusters clustersOf(const Mesh& mesh, const PoseTable& poses, std::size_t count, int threads) {
    return poses.deforming ? clusterParts(mesh, poses.skin, count) : clusterVertices(mesh, poses.skin, count, threads);
}

VertexClusters clusterParts(const Mesh& mesh, const Skin& skin, std::size_t count) {
    assert(skin.influences == 1 && count <= mesh.vertexCount());
    const Source source{mesh, skin, true};
    const std::size_t fronts = mesh.frontVertexCount();
    const std::vector<std::uint32_t> part(skin.joints.begin(), skin.joints.begin() + long(fronts));
    std::vector<Group> groups =
        mergedOrSplit(source, groupsOf(source, part), fronts, mesh.two_sided ? (count + 1) / 2 : count);
    // Give each cluster of fronts a cluster of backs, which follow behind all fronts.
    for (std::size_t g = 0, of_fronts = groups.size(); g < of_fronts && mesh.two_sided; ++g) {
        Group back = groups[g];
        for (std::uint32_t& v : back.vertices) v += std::uint32_t(fronts);
        groups.push_back(std::move(back));
    }
    return numberGroups(std::move(groups), mesh.vertexCount());
}

}  // namespace penumbra
