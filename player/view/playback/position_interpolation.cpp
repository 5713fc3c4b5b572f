#include "player/view/playback/position_interpolation.h"

#include <algorithm>

namespace penumbra {

PositionInterpolation::PositionInterpolation(const AssetView& asset)
    : asset_(&asset),
      points_(asset.mesh.pointCount()),
      next_(points_.size()),
      inputs_(asset.animation.input_names.size()) {}

void PositionInterpolation::evaluate(std::size_t from, std::size_t to, double part) {
    if (part >= 1) from = to;
    readPositions(*asset_, from, points_);
    const std::span<const float> inputs = asset_->animation.inputsOf(from);
    std::copy(inputs.begin(), inputs.end(), inputs_.begin());
    if (part <= 0 || part >= 1) return;
    readPositions(*asset_, to, next_);
    const auto t = float(part);
    for (std::size_t i = 0; i < points_.size(); ++i) points_[i] = points_[i] * (1 - t) + next_[i] * t;
    const std::span<const float> next = asset_->animation.inputsOf(to);
    for (std::size_t i = 0; i < inputs_.size(); ++i) inputs_[i] = inputs_[i] * (1 - t) + next[i] * t;
}

}  // namespace penumbra
