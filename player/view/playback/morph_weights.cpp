#include "player/view/playback/morph_weights.h"

#include <algorithm>

#include "runtime/evaluate/deformation.h"

namespace penumbra {

std::span<const std::string_view> morphNames(const AssetView& asset) {
    return std::span(asset.animation.input_names).last(asset.mesh.morphs.count());
}

WeightedPose withWeights(const AssetView& asset, WeightedPose pose, std::span<const float> weights) {
    const std::size_t inputs = asset.animation.input_names.size();
    if (weights.size() != asset.mesh.morphs.count()) return pose;
    std::vector<float> all(inputs);
    std::copy(weights.begin(), weights.end(), all.end() - std::ptrdiff_t(weights.size()));
    for (const InputJointView& input : asset.model.input_joints)
        if (input.column + weights.size() >= inputs)
            pose.bones[std::size_t(input.joint)] = inputBone(asset, input, all);
    if (pose.pose.size() >= weights.size())
        std::copy(weights.begin(), weights.end(), pose.pose.end() - std::ptrdiff_t(weights.size()));
    return pose;
}

}  // namespace penumbra
