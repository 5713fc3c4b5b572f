#include "bake/poses/morph_poses.h"

#include <algorithm>

#include "bake/common/random_numbers.h"
#include "bake/poses/sample_poses.h"
#include "formats/rig/rig_morphs.h"

namespace penumbra {

std::vector<float> weightsOf(const Rig& rig, std::span<const RigFrame> frames) {
    std::vector<float> out;
    for (const RigFrame& frame : frames) {
        const std::vector<float> weights = weightsAt(rig, frame.clip, frame.time);
        out.insert(out.end(), weights.begin(), weights.end());
    }
    return out;
}

WeightLimits weightLimits(const Rig& rig, std::span<const RigFrame> frames) {
    const std::vector<float>& rest = rig.mesh.morphs.rest_weights;
    const std::vector<float> weights = weightsOf(rig, frames);
    WeightLimits limits{rest, rest};
    for (std::size_t m = 0; m < rest.size(); ++m) {
        for (std::size_t i = m; i < weights.size(); i += rest.size()) {
            if (i == m) limits.low[m] = limits.high[m] = weights[i];
            limits.low[m] = std::min(limits.low[m], weights[i]);
            limits.high[m] = std::max(limits.high[m], weights[i]);
        }
        if (limits.low[m] < limits.high[m]) continue;
        limits.low[m] = std::min(rest[m], 0.0f);
        limits.high[m] = std::max(rest[m], 1.0f);
    }
    return limits;
}

std::vector<float> sampleWeights(const WeightLimits& limits, std::size_t count, std::uint64_t seed,
                                 std::size_t first_dimension) {
    const std::size_t width = limits.low.size();
    std::vector<float> weights(count * width);
    for (std::size_t m = 0; m < width; ++m) {
        const HaltonDimension halton(first_dimension + m, seed);
        for (std::size_t p = 0; p < count; ++p)
            weights[p * width + m] =
                limits.low[m] + (limits.high[m] - limits.low[m]) * float(halton.value(std::uint64_t(p) + 1));
    }
    return weights;
}

std::vector<float> mixWeights(const Rig& rig, std::span<const RigFrame> frames, std::size_t count, std::uint64_t seed) {
    const std::size_t width = rig.mesh.morphs.count();
    const std::vector<float> known = weightsOf(rig, frames);
    std::vector<bool> changes(width);
    for (std::size_t i = 0; i < known.size(); ++i)
        changes[i % width] = changes[i % width] || known[i] != known[i % width];
    std::vector<float> weights;
    for (std::size_t p = 0; p < count && width > 0; ++p) {
        // Another stream than that of the limbs, so that both are free of each other.
        std::uint64_t state = ~seed * 0x9e3779b97f4a7c15u + p;
        state = nextRandom(state);
        for (std::size_t m = 0; m < width; ++m) {
            const double drawn = nextUniform(state);
            weights.push_back(changes[m] ? known[std::size_t(drawn * double(frames.size())) * width + m]
                                         : float(drawn));
        }
    }
    return weights;
}

}  // namespace penumbra
