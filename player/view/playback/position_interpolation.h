#pragma once
// Interpolates positions between the sampled frames of a deforming mesh, which PoseInterpolation cannot as it has no
// skeleton.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

class PositionInterpolation {
public:
    // `asset` has playback positions and outlives this object.
    explicit PositionInterpolation(const AssetView& asset);

    // Computes every number `part` of the way from frame `from` to frame `to`, 0..1, on a straight line. At 0 and 1
    // it is the frame's, bit by bit. Allocates nothing.
    void evaluate(std::size_t from, std::size_t to, double part);
    std::span<const Vec3> points() const { return points_; }   // [Vs]
    std::span<const float> inputs() const { return inputs_; }  // [X]

private:
    const AssetView* asset_;
    std::vector<Vec3> points_, next_;
    std::vector<float> inputs_;
};

}  // namespace penumbra
