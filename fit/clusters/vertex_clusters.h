#pragma once
// Clusters of vertices that move alike: mean-shift on the skinning weights, then merged or split to the asked number.
#include <cstdint>
#include <vector>

#include "fit/clusters/pose_table.h"

namespace penumbra {

constexpr std::size_t kAutoClusterSize = 432;  // vertices; the 13,380-vertex character of the papers' size gets 31

struct VertexClusters {
    std::vector<std::uint32_t> cluster_of_vertex;      // [V]
    std::vector<std::vector<std::uint32_t>> vertices;  // ascending in each cluster; clusters by their first vertex
    std::vector<int> joint;                            // the joint with the largest total weight in the cluster
};

// 1. Mean-shift (mean_shift.h). 2. Clusters of fewer than V/1000 vertices join the one of the nearest mean weights.
// 3. Too many: the pair whose union raises the sum of squared distances to the mean weights least (Ward) is merged,
// again and again. 4. Too few: the largest is cut at the median along its longest principal axis.
// `count` 0: as many as step 2 leaves, or V / kAutoClusterSize rounded up if that is more. 1 <= count <= V otherwise.
// Parts of a deforming mesh (influences = 1) are clusters from the start, and step 3 merges those whose centres are
// near (Ward on rest positions). Fronts and backs are never in one cluster: of a two-sided mesh all this is done with
// the fronts and half the number (rounded up), then each cluster gets one of their backs.
VertexClusters clusterVertices(const Mesh& mesh, const Skin& skin, std::size_t count, int threads);
VertexClusters clusterParts(const Mesh& mesh, const Skin& skin, std::size_t count);
// Either, by what the poses are of.
VertexClusters clustersOf(const Mesh& mesh, const PoseTable& poses, std::size_t count, int threads);

}  // namespace penumbra
