#pragma once
// Counts the bytes of the clusters of an asset by what they are for.
#include <cstddef>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

inline std::size_t bytesOf(const NumbersView& numbers) {
    return numbers.count * bytesPerNumber(numbers.precision) + numbers.scale.size_bytes();
}

// Returns the bytes of the means and the components, which have the vertices.
inline std::size_t outputBytes(const std::vector<ClusterView>& clusters) {
    std::size_t bytes = 0;
    for (const ClusterView& c : clusters) bytes += bytesOf(c.mean) + bytesOf(c.basis);
    return bytes;
}

// Returns the bytes of what takes the pose to the scores of the components.
inline std::size_t regressionBytes(const std::vector<ClusterView>& clusters) {
    std::size_t bytes = 0;
    for (const ClusterView& c : clusters)
        bytes += bytesOf(c.input_basis) + c.feature_mean.size_bytes() + bytesOf(c.weights) + bytesOf(c.group_min) +
                 bytesOf(c.group_max) + bytesOf(c.hidden) + c.bias.size_bytes() + c.groups.size_bytes() +
                 c.group_weight.size_bytes() + c.unit_group.size_bytes() + c.input_min.size_bytes() +
                 c.input_max.size_bytes();
    return bytes;
}

}  // namespace penumbra
