#pragma once
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "pack/compress/span_projector.h"

namespace penumbra {

// The span of every cluster's components around its mean. Numbers are those of all vertices, [V * stride].
struct ComponentSpans {
    std::vector<SpanProjector> projectors;  // [cluster]
    std::vector<float> mean;                // [V * stride]

    explicit ComponentSpans(const AssetView& asset);
    double squaredDistance(const ClusterView& cluster, std::size_t index, std::span<const float> coefficients) const;
    // Writes the point of the cluster's span that is nearest to `coefficients`, for the vertices of the cluster.
    void project(const ClusterView& cluster, std::size_t index, std::span<const float> coefficients,
                 std::span<float> out) const;
};

}  // namespace penumbra
