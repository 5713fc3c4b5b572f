#include "bake/poses/sample_poses.h"

#include <algorithm>
#include <numeric>

#include "bake/common/random_numbers.h"

namespace penumbra {

namespace {

// Returns the prime of this index, from 0. The list of primes grows as it is needed.
std::uint32_t primeNumber(std::size_t index) {
    static std::vector<std::uint32_t> primes{2};
    for (std::uint32_t n = primes.back() + 1; primes.size() <= index; ++n)
        if (std::none_of(primes.begin(), primes.end(), [&](std::uint32_t p) { return n % p == 0; }))
            primes.push_back(n);
    return primes[index];
}

}  // namespace

HaltonDimension::HaltonDimension(std::size_t dimension, std::uint64_t seed) : base_(primeNumber(dimension)) {
    std::uint64_t state = seed * 0x9e3779b97f4a7c15u + dimension;
    nextRandom(state);
    // Places go down to 2^-32, since finer ones are below the resolution of a float pose.
    for (double size = 1; size > 0x1p-32; size /= base_) {
        std::vector<std::uint32_t>& digits = digit_.emplace_back(base_);
        std::iota(digits.begin(), digits.end(), 0u);
        if (seed != 0) shuffle(std::span(digits), state);
    }
}

double HaltonDimension::value(std::uint64_t index) const {
    double value = 0, size = 1;
    for (const std::vector<std::uint32_t>& digits : digit_) {
        size /= base_;
        value += size * digits[index % base_];
        index /= base_;
    }
    return std::min(value, 1 - 0x1p-53);
}

std::vector<float> samplePoses(const Rig& rig, const JointLimits& limits, std::size_t count, std::uint64_t seed) {
    const std::size_t width = limits.low.size();
    std::vector<float> poses(count * width);
    std::size_t dimension = 0;
    for (std::size_t c = 0; c < width; ++c) {
        const double range = limits.high[c] - limits.low[c];
        const HaltonDimension halton(range > 0 ? dimension++ : 0, seed);
        // Points are used from the second one on: the first of the plain sequence is the corner of all least angles.
        for (std::size_t p = 0; p < count; ++p)
            poses[p * width + c] = float(limits.low[c] + (range > 0 ? range * halton.value(p + 1) : 0));
    }
    // Joints that share a node turn alike: they take the numbers of the node's first joint.
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j) {
        const auto first =
            std::size_t(std::find(rig.node_of_joint.begin(), rig.node_of_joint.end(), rig.node_of_joint[j]) -
                        rig.node_of_joint.begin());
        for (std::size_t p = 0; p < count; ++p)
            std::copy_n(&poses[p * width + 3 * first], 3, &poses[p * width + 3 * j]);
    }
    return poses;
}

}  // namespace penumbra
