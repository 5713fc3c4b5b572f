#pragma once
// Clusters of vertices that move alike: mean-shift on the skinning weights, then merging or splitting to the number
// that is asked for.
#include <cstdint>
#include <vector>

#include "fit/clusters/pose_table.h"

namespace penumbra {

constexpr std::size_t kAutoClusterSize = 432;  // vertices in a cluster; the 13,380-vertex character gets 31 clusters

struct VertexClusters {
    std::vector<std::uint32_t> cluster_of_vertex;  // [V]
    // Vertices are ascending in each cluster, and clusters come in the order of their first vertex.
    std::vector<std::vector<std::uint32_t>> vertices;
    std::vector<int> joint;  // the joint with the largest total weight in each cluster
};

// Clusters the vertices into `count` clusters, 1 <= count <= V; 0 lets the function choose.
//
// 1. Mean-shift (mean_shift.h) groups the vertices by their skinning weights.
// 2. Clusters of fewer than V/1000 vertices join the cluster with the nearest mean weights.
// 3. When there are too many clusters, the pair whose union adds least to the sum of squared distances from the mean
//    weights (Ward) is merged, again and again. With `count` 0, the number is what step 2 leaves, or V /
//    kAutoClusterSize rounded up if that is more.
// 4. When there are too few, the largest is cut at the median along its longest principal axis.
//
// clusterParts() does the same for a deforming mesh (influences = 1). It starts from the parts, and step 3 merges those
// whose centers are near (Ward on rest positions). A front and a back are never in one cluster: for a two-sided mesh
// the steps run on the fronts with half the number, rounded up, and then each cluster of fronts gets a cluster of their
// backs.
VertexClusters clusterVertices(const Mesh& mesh, const Skin& skin, std::size_t count, int threads);
VertexClusters clusterParts(const Mesh& mesh, const Skin& skin, std::size_t count);
// Calls the one of the two that suits the mesh that the poses belong to.
VertexClusters clustersOf(const Mesh& mesh, const PoseTable& poses, std::size_t count, int threads);

}  // namespace penumbra
