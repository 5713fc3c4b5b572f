#pragma once
// Weights of morph targets in poses that no clip has. They vary on their own: a face does what it does whatever the
// limbs do, and a model that has seen a smile only along with a raised arm cannot tell the two apart.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/rig/rig_poses.h"

namespace penumbra {

// The least and the largest weight of each target [M].
struct WeightLimits {
    std::vector<float> low, high;
};
// Returns the ranges over the frames. A weight that no frame changes goes from 0 to 1, and to its weight at rest where
// that is outside.
WeightLimits weightLimits(const Rig& rig, std::span<const RigFrame> frames);

// Samples weights [count, M] within their limits as sample_poses.h does, in the Halton dimensions from
// `first_dimension` on.
std::vector<float> sampleWeights(const WeightLimits& limits, std::size_t count, std::uint64_t seed,
                                 std::size_t first_dimension);

// Mixes weights [count, M]: each is that of a random one of the frames, or a random one between 0 and 1 where no frame
// changes it. Row k depends on nothing but the frames, the seed and k.
std::vector<float> mixWeights(const Rig& rig, std::span<const RigFrame> frames, std::size_t count, std::uint64_t seed);

// Returns the weights [frames, M].
std::vector<float> weightsOf(const Rig& rig, std::span<const RigFrame> frames);

}  // namespace penumbra
