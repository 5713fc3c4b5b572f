#pragma once
// Fits all clusters of a bake, as many at a time as memory holds.
#include <vector>

#include "fit/clusters/vertex_clusters.h"
#include "fit/visibility/fit_composed.h"
#include "fit/visibility/fit_visibility.h"
#include "fit/visibility/split_frames.h"

namespace penumbra {

struct FitJob {
    const VisibilityReader& reader;
    const FitOptions& options;
    const FitObserver& observer;
    const PoseTable& poses;
    const VertexClusters& clusters;
    const Split& split;
    std::vector<int> folds;
};

// Fits every cluster of `model`, whose mesh, tangents and cluster_of_vertex are set.
std::vector<ClusterFit> fitClusters(const FitJob& job, const Model& model);
// Does the same for a composed model. model.composition is set but for its residual.
std::vector<ComposedFit> fitComposedClusters(const FitJob& job, const Model& model);

}  // namespace penumbra
