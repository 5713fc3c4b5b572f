#pragma once
// A few of many poses: the most different ones, the most representative ones, or random ones to compare with.
#include <cstdint>
#include <vector>

#include "bake/pose_features.h"

namespace penumbra {

struct ChosenPoses {
    std::vector<std::size_t> frames;  // in the order of choice, so that the first n are the choice of n
    std::vector<double> distance;     // of each to the nearest chosen before it; 0 for the first
    // Of all candidates to the nearest chosen one: what the choice leaves uncovered.
    double largest_gap = 0, mean_gap = 0;
};

// Farthest-point sampling (Gonzalez 1985): first the frame nearest to the mean, then always the one farthest from all
// chosen so far; the first of equals. Largest gap at most twice that of the best possible choice. Stops before `count`
// when all that is left equals a chosen frame. O(count x frames).
ChosenPoses chooseFarthest(const PoseFeatures& features, std::size_t count, int threads);

// Greedy k-median (Nemhauser, Wolsey, Fisher 1978; at least 1 - 1/e of the best possible gain): first the frame with
// the least mean distance to all others, then always the one that lowers the mean gap most; the first of equals.
// Follows how often poses occur, where the farthest ones are the rarest. Stops as chooseFarthest does. UsageError for
// more than 23170 frames: their distances would take more than 2 GiB.
ChosenPoses chooseRepresentative(const PoseFeatures& features, std::size_t count, int threads);

// Uniform without replacement; count <= frames.
ChosenPoses chooseRandom(const PoseFeatures& features, std::size_t count, std::uint64_t seed, int threads);

}  // namespace penumbra
