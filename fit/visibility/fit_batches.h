#pragma once
// Fits all clusters of a bake, as many at a time as memory holds.
#include <vector>

#include "fit/clusters/vertex_clusters.h"
#include "fit/visibility/fit_composed.h"
#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/part_table.h"

namespace penumbra {

struct FitJob {
    const VisibilityReader& reader;
    const FitOptions& options;
    const FitObserver& observer;
    const PoseTable& poses;
    const VertexClusters& clusters;
    const Split& split;
    std::vector<int> folds;
    // Where it is set, the clusters learn the indirect transfer in these colours instead of visibility.
    const ColorAxes* indirect = nullptr;
};

// Groups consecutive clusters, [begin, end), whose numbers together fit into so many bytes. No result depends on them.
constexpr std::size_t kBatchBytes = std::size_t(128) << 20;
std::vector<std::pair<std::size_t, std::size_t>> makeBatches(
    const std::vector<std::vector<std::uint32_t>>& vertices_of_cluster, std::size_t bytes_per_vertex,
    std::size_t batch_bytes = kBatchBytes);
// Returns the mean rest position of some vertices.
Vec3 centerOf(const Mesh& mesh, const std::vector<std::uint32_t>& vertices);

// Fits every cluster of `model`, whose mesh, tangents and cluster_of_vertex are set.
std::vector<ClusterFit> fitClusters(const FitJob& job, const Model& model);

// The fits of all clusters of a composed model share this. The model's composition is set but for its residual.
struct ComposedClusters {
    const Model& model;
    FeatureRecipe recipe;
    PartTable table;
    FarTables far;
    std::vector<PosedPart> posed;  // [F, P]
    HiddenVertices hidden = HiddenVertices::kLearned;

    ComposedClusters(const FitJob& job, const Model& composed);
};
// The numbers of a cluster, [F, Vc n] each.
struct ClusterCoefficients {
    MatrixF local, whole;
};
// Reads the numbers of some clusters, which must fit into memory.
std::vector<ClusterCoefficients> readComposedCoefficients(const FitJob& job, const Model& model,
                                                          std::span<const std::size_t> clusters);
// Fits cluster c of the job to its numbers.
ComposedFit fitComposedCluster(const FitJob& job, const ComposedClusters& shared, std::size_t c,
                               ClusterCoefficients coefficients);
// Fits every cluster of a composed model.
std::vector<ComposedFit> fitComposedClusters(const FitJob& job, const Model& model, HiddenVertices hidden);

}  // namespace penumbra
