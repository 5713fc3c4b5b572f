#include "bake/pilot/pose_kinds.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

PoseCounts shareOf(const PoseCounts& counts, double share) {
    const auto part = [share](std::int64_t n) {
        return n > 0 ? std::max<std::int64_t>(1, std::llround(share * double(n))) : n;
    };
    return {part(counts.sample), part(counts.mix), part(counts.cover)};
}

std::string optionsOf(const PoseCounts& counts) {
    std::string text = counts.mix + counts.cover == 0 ? "--choose all" : "";
    const auto add = [&](const char* flag, std::int64_t count) {
        if (count > 0) text += (text.empty() ? "" : " ") + std::string(flag) + " " + std::to_string(count);
    };
    add("--sample", counts.sample);
    add("--mix", counts.mix);
    add("--cover", counts.cover);
    return text;
}

std::vector<PoseCounts> candidateKinds(const PoseCounts& most) {
    std::vector<PoseCounts> kinds = {{}};
    for (const PoseCounts& kind :
         {PoseCounts{most.sample, 0, 0}, PoseCounts{0, most.mix, 0}, PoseCounts{0, most.mix, most.cover}, most})
        if (std::ranges::find(kinds, kind) == kinds.end()) kinds.push_back(kind);
    return kinds;
}

TrialRatio ratioOf(const PoseTrial& trial, const PoseTrial& other) {
    const std::size_t folds = trial.errors.size();
    assert(folds > 0 && other.errors.size() == folds);
    std::vector<double> logs;
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < folds; ++k) sum += logs.emplace_back(std::log(trial.errors[k] / other.errors[k]));
    const double mean = sum / double(folds);
    for (const double x : logs) squares += (x - mean) * (x - mean);
    return {std::exp(mean), folds > 1 ? std::sqrt(squares / double(folds * (folds - 1))) : 0};
}

std::size_t chooseTrial(std::span<const PoseTrial> trials) {
    assert(!trials.empty());
    // 1. The least mean of those that are better than the clips alone beyond doubt.
    std::size_t best = 0;
    double least = 1;
    for (std::size_t t = 1; t < trials.size(); ++t) {
        const TrialRatio ratio = ratioOf(trials[t], trials[0]);
        if (-std::log(ratio.mean) <= std::max(kWorthPoses, ratio.noise) || ratio.mean >= least) continue;
        best = t;
        least = ratio.mean;
    }
    // 2. Fewer poses, where they are as good.
    const double limit = least * (1 + kSameError);
    for (std::size_t t = 1; t < trials.size(); ++t) {
        const TrialRatio ratio = ratioOf(trials[t], trials[0]);
        const bool good = -std::log(ratio.mean) > std::max(kWorthPoses, ratio.noise) && ratio.mean <= limit;
        if (best > 0 && good && trials[t].counts.total() < trials[best].counts.total()) best = t;
    }
    return best;
}

}  // namespace penumbra
