#pragma once
// Values over time as a mean and a few patterns, each with a weight that changes: what morph targets can play.
#include <cstddef>
#include <span>
#include <vector>

namespace penumbra {

struct PrincipalWeights {
    std::size_t count = 0;          // K
    std::vector<float> mean;        // [V]
    std::vector<float> components;  // [K, V]
    std::vector<float> weights;     // [F, K], the largest of each component is 1 or -1
    double rms = 0, max = 0;        // error of mean + weights x components over all frames and vertices
    // The rms with 0, 1, 2, ... components, up to all that there are; without rounding.
    std::vector<double> rms_of_count;
};

// How many components are wanted: `count`, or where that is 0 as few as have an rms of at most `max_rms`, or all of
// them where that is 0, too.
struct PatternChoice {
    std::size_t count = 0;
    double max_rms = 0;
};

// `values` is [F, V], F and V at least 1. Throws Unsupported where F and V are both above kMaxFrames.
PrincipalWeights principalWeights(std::span<const float> values, std::size_t frames, const PatternChoice& choice);
constexpr std::size_t kMaxFrames = 6000;

}  // namespace penumbra
