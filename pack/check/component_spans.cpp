#include "pack/check/component_spans.h"

#include <algorithm>

namespace penumbra {

ComponentSpans::ComponentSpans(const AssetView& asset) {
    mean.resize(asset.mesh.positions.size() * std::size_t(asset.model.stride));
    std::size_t first = 0;
    for (const ClusterView& cluster : asset.model.clusters) {
        decode(cluster.mean, std::span(mean).subspan(first, cluster.mean.count));
        first += cluster.mean.count;
        std::vector<float> basis(cluster.basis.count);
        decode(cluster.basis, basis);
        projectors.emplace_back(basis, cluster.mean.count);
    }
}

double ComponentSpans::squaredDistance(const ClusterView& cluster, std::size_t index,
                                       std::span<const float> coefficients) const {
    const std::size_t count = cluster.mean.count;
    const std::size_t first = count / std::max<std::size_t>(1, cluster.vertex_count) * cluster.first_vertex;
    return projectors[index].squaredDistance(coefficients.subspan(first, count), std::span(mean).subspan(first, count));
}

void ComponentSpans::project(const ClusterView& cluster, std::size_t index, std::span<const float> coefficients,
                             std::span<float> out) const {
    const std::size_t count = cluster.mean.count;
    const std::size_t first = count / std::max<std::size_t>(1, cluster.vertex_count) * cluster.first_vertex;
    projectors[index].project(coefficients.subspan(first, count), std::span(mean).subspan(first, count),
                              out.subspan(first, count));
}

}  // namespace penumbra
