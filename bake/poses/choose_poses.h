#pragma once
// Chooses a few of many poses: the most different ones, the most representative ones, or random ones to compare with.
#include <cstdint>
#include <vector>

#include "bake/poses/pose_features.h"

namespace penumbra {

struct ChosenPoses {
    std::vector<std::size_t> frames;  // in the order of choice: the first n of them are the choice of n poses
    std::vector<double> distance;     // distance of each frame to the nearest one chosen before it; 0 for the first
    // The distance of every candidate to the nearest chosen one, its maximum and its mean: what the choice leaves
    // uncovered.
    double largest_gap = 0, mean_gap = 0;
};

// Chooses by farthest-point sampling (Gonzalez 1985). The frame nearest to the mean comes first; then always the one
// that is farthest from all chosen so far, and of equals the first. The largest gap is at most twice that of the best
// possible choice. The function stops before `count` when every frame that is left equals a chosen one. It takes
// O(count x frames).
ChosenPoses chooseFarthest(const PoseFeatures& features, std::size_t count, int threads);

// Chooses by greedy k-median (Nemhauser, Wolsey, Fisher 1978), which reaches at least 1 - 1/e of the best possible
// gain. The frame with the least mean distance to all others comes first; then always the one that lowers the mean
// gap most, and of equals the first. The choice follows how often poses occur, whereas the farthest poses are the
// rarest. It stops as chooseFarthest() does. Throws UsageError for more than 23170 frames, whose distances would take
// more than 2 GiB.
ChosenPoses chooseRepresentative(const PoseFeatures& features, std::size_t count, int threads);

// Chooses uniformly without replacement; count <= features.frames.
ChosenPoses chooseRandom(const PoseFeatures& features, std::size_t count, std::uint64_t seed, int threads);

}  // namespace penumbra
