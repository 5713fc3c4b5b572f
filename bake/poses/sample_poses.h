#pragma once
// Samples poses within the joints' limits: "regularly sampling the space of input parameters" (Nowrouzezahrai 2009,
// section 5.1). A grid has far too many points in 3 J dimensions, whereas a low-discrepancy sequence can have any
// number.
#include <cstdint>
#include <vector>

#include "bake/poses/joint_limits.h"

namespace penumbra {

// Computes point `index` (from 0) of the Halton sequence in dimension `dimension`, in [0, 1). The base is the prime
// of that number. Seed 0 is the plain sequence, whose dimensions beyond the first ten or so are correlated for short
// lengths. Any other seed draws random permutations of the digits, one for each place of each dimension (Braaten and
// Weller 1979; with trailing zeros permuted as well, so that no point repeats).
class HaltonDimension {
public:
    HaltonDimension(std::size_t dimension, std::uint64_t seed);
    double value(std::uint64_t index) const;

private:
    std::uint32_t base_;
    std::vector<std::vector<std::uint32_t>> digit_;  // [place][digit]
};

// Samples `count` poses as rotation vectors [count, 3J]. Each component with low < high is a dimension of its own and
// uniform in its range; the others stay at low. A shorter list is a prefix of a longer one. The same seed gives the
// same poses.
std::vector<float> samplePoses(const Rig& rig, const JointLimits& limits, std::size_t count, std::uint64_t seed);

}  // namespace penumbra
