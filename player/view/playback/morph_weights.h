#pragma once
// Poses with other weights of morph targets than a clip has.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// The names of an asset's morph targets [M].
std::span<const std::string_view> morphNames(const AssetView& asset);

// A pose with the weights [M] applied: the bones of the joints that stand for them, and the last numbers of the pose
// where the model reads it.
struct WeightedPose {
    std::vector<Affine> bones;
    std::vector<float> pose;
};
WeightedPose withWeights(const AssetView& asset, WeightedPose pose, std::span<const float> weights);

}  // namespace penumbra
