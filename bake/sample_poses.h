#pragma once
// "Regularly sampling the space of input parameters" (paper 000, section 5.1): a grid has far too many points in 3 J
// dimensions, a low-discrepancy sequence has any number.
#include <cstdint>
#include <vector>

#include "bake/joint_limits.h"

namespace penumbra {

// Point `index` (from 0) of the Halton sequence in dimension `dimension` (base: the prime of that number), in [0, 1).
// seed 0: the plain sequence, whose dimensions beyond the first ten or so are correlated for short lengths. Else the
// digits go through random permutations, one for each place of each dimension, drawn from the seed (Braaten and Weller
// 1979; with trailing zeros permuted as well, so that no point repeats).
class HaltonDimension {
public:
    HaltonDimension(std::size_t dimension, std::uint64_t seed);
    double value(std::uint64_t index) const;

private:
    std::uint32_t base_;
    std::vector<std::vector<std::uint32_t>> digit_;  // [place][digit]
};

// `count` poses as rotation vectors [count, 3J]: each component with low < high is a dimension of its own, uniform in
// its range; the others stay at low. Prefixes of a longer list; the same for the same seed.
std::vector<float> samplePoses(const Rig& rig, const JointLimits& limits, std::size_t count, std::uint64_t seed);

}  // namespace penumbra
