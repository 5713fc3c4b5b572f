#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "fit/clusters/mean_shift.h"
#include "fit/clusters/vertex_clusters.h"
#include "tests/fit/synthetic_character.h"

namespace penumbra::test_clusters {
namespace {

// Vertices of six known groups with jittered weights. Four groups follow one joint each, and two follow two joints by
// half.
struct Groups {
    Mesh mesh;
    Skin skin;
    std::vector<int> group_of_vertex;
};

Groups jitteredGroups(std::size_t vertices, float jitter) {
    Groups groups;
    groups.skin.joint_names = {"a", "b", "c", "d"};
    groups.skin.parents = {-1, 0, 1, 2};
    groups.skin.influences = 2;
    constexpr float kFirstWeight[6] = {1, 1, 1, 1, 0.5f, 0.5f};
    constexpr std::uint16_t kJoints[6][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 1}, {2, 3}};
    std::mt19937 random{5};
    std::uniform_real_distribution<float> uniform(0, jitter);
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::size_t g = v % 6;
        const float w = std::max(kFirstWeight[g] - uniform(random), 0.f);
        groups.skin.joints.insert(groups.skin.joints.end(), {kJoints[g][0], kJoints[g][1]});
        groups.skin.weights.insert(groups.skin.weights.end(), {w, 1 - w});
        groups.group_of_vertex.push_back(int(g));
        groups.mesh.rest_positions.push_back({float(v % 10), float(v / 10), float(g)});
    }
    return groups;
}

TEST(MeanShift, FindsKnownGroups) {
    const Groups groups = jitteredGroups(3000, 0.15f);
    const std::vector<std::uint32_t> label = meanShiftSkinWeights(groups.skin);
    EXPECT_EQ(*std::max_element(label.begin(), label.end()), 5u);
    for (std::size_t v = 0; v < label.size(); ++v) EXPECT_EQ(label[v], v % 6) << "vertex " << v;
}

TEST(MeanShift, WideBandwidthJoinsAll) {
    const std::vector<std::uint32_t> label = meanShiftSkinWeights(jitteredGroups(600, 0.1f).skin, 2.0);
    EXPECT_EQ(*std::max_element(label.begin(), label.end()), 0u);
}

TEST(Clusters, HaveTheAskedNumberWhateverItIs) {
    const Groups groups = jitteredGroups(600, 0.15f);
    for (std::size_t count : {1, 3, 6, 17, 600}) {
        const VertexClusters clusters = clusterVertices(groups.mesh, groups.skin, count, 1);
        ASSERT_EQ(clusters.vertices.size(), count);
        ASSERT_EQ(clusters.joint.size(), count);
        std::set<std::uint32_t> seen;
        for (std::size_t c = 0; c < count; ++c)
            for (std::uint32_t v : clusters.vertices[c]) {
                EXPECT_EQ(clusters.cluster_of_vertex[v], c);
                EXPECT_TRUE(seen.insert(v).second);
            }
        EXPECT_EQ(seen.size(), 600u);
    }
}

TEST(Clusters, SplittingKeepsGroupsApartAndMergingPairsTheNearest) {
    const Groups groups = jitteredGroups(600, 0.15f);
    const VertexClusters split = clusterVertices(groups.mesh, groups.skin, 12, 1);
    for (const auto& vertices : split.vertices)
        for (std::uint32_t v : vertices) EXPECT_EQ(groups.group_of_vertex[v], groups.group_of_vertex[vertices[0]]);
    // Six groups become four: each half-and-half group joins one of the two that it lies between.
    const VertexClusters merged = clusterVertices(groups.mesh, groups.skin, 4, 1);
    for (std::size_t v = 0; v < 600; ++v)
        if (groups.group_of_vertex[v] >= 4) {
            const int joint = merged.joint[merged.cluster_of_vertex[v]];
            EXPECT_EQ(joint / 2, groups.group_of_vertex[v] - 4) << "vertex " << v;
        }
}

TEST(Clusters, TubeGetsOneClusterABone) {
    const Mesh mesh = synthetic::tube(40, 10);
    const VertexClusters clusters = clusterVertices(mesh, synthetic::chainSkin(mesh), 0, 2);
    EXPECT_EQ(std::set<int>(clusters.joint.begin(), clusters.joint.end()), (std::set<int>{0, 1, 2, 3}));
}

TEST(Clusters, DoNotDependOnThreads) {
    const Groups groups = jitteredGroups(3000, 0.4f);
    const VertexClusters one = clusterVertices(groups.mesh, groups.skin, 20, 1);
    for (int threads : {2, 8})
        EXPECT_EQ(clusterVertices(groups.mesh, groups.skin, 20, threads).cluster_of_vertex, one.cluster_of_vertex);
}

}  // namespace
}  // namespace penumbra::test_clusters
