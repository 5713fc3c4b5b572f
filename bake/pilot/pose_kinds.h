#pragma once
// Chooses which kinds of made poses a list gets beside the frames of its clips, by the errors of trial fits.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace penumbra {

// How many poses of each kind; all zero: the frames of the clips alone.
struct PoseCounts {
    std::int64_t sample = 0, mix = 0, cover = 0;

    std::int64_t total() const { return sample + mix + cover; }
    bool operator==(const PoseCounts&) const = default;
};

// Returns `share` of each number, at least 1 of a kind that has any.
PoseCounts shareOf(const PoseCounts& counts, double share);

// Returns "--sample 200 --mix 300 --cover 300" without the kinds that have none. "--choose all" stands for clips alone,
// and goes with sampled poses, which alone would leave the frames of the clips out.
std::string optionsOf(const PoseCounts& counts);

// Returns the combinations that are worth a trial, clips alone first: sampled poses, mixed ones, mixed and covering
// ones, and all three. Kinds of which `most` has none are left out. Covering poses without mixed ones are no candidate:
// on all measured rigs they were as good as mixed ones, or worse (docs/accuracy.md).
std::vector<PoseCounts> candidateKinds(const PoseCounts& most);

// The errors that trial fits leave with one combination.
struct PoseTrial {
    PoseCounts counts;           // of the list that would be made
    std::vector<double> errors;  // [folds] rms error of V over the frames of the fold's own clips, > 0
};

// A trial against the one of the clips alone, by the logarithms of the ratios of their errors in each fold.
struct TrialRatio {
    double mean = 1;   // geometric mean of the ratios
    double noise = 0;  // standard error of the mean logarithm; 0 of a single fold
};
TrialRatio ratioOf(const PoseTrial& trial, const PoseTrial& other);

// Returns the trial to take. trials[0] is that of the clips alone, which stays unless another one has a mean ratio to
// it that is below 1 by more than kWorthPoses and by more than its noise. Of those that have, the least mean counts;
// a trial of fewer poses within kSameError of it is taken in its place.
constexpr double kWorthPoses = 0.01, kSameError = 0.005;
std::size_t chooseTrial(std::span<const PoseTrial> trials);

}  // namespace penumbra
