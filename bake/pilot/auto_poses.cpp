#include "bake/pilot/auto_poses.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "bake/pilot/pose_pilot.h"
#include "bake/visibility/bake_estimate.h"
#include "formats/common/part_table.h"

namespace penumbra {

namespace {

constexpr double kShares[] = {1, 0.5, 0.25, 0.125};  // of the most poses, for the minutes
constexpr double kMaxPoses = 2010000;                // more than a list can have

// Returns the minutes that a pose of the later bake takes, from a probe of frames of the clips.
double minutesOfPose(const AutoInput& input, const AutoOptions& wanted, int threads) {
    BakeOptions options;
    options.clips = input.plan.candidates.clip_names;
    options.fps = input.options.fps;
    options.rays = wanted.rays;
    options.rig = input.options.rig;
    const PartTable parts = makePartTable(input.plan.rig.mesh, input.plan.rig.skin);
    if (parts.partCount() >= 2) options.local = LocalMoments{};
    const BakePlan plan = planBake(input.rigs, options);
    return estimateBake(plan, options, threads).seconds / 60 / double(plan.header.frames.frameCount());
}

// Returns the largest share of these numbers that so many poses leave room for, 0 where none does.
double allowedShare(const PoseCounts& counts, double poses) {
    for (const double share : kShares)
        if (double(shareOf(counts, share).total()) <= poses) return share;
    return 0;
}

// A combination, in the numbers of the list and in those of the pilot.
struct Combination {
    PoseCounts listed, tried;
};

// The clips alone, and the kinds of which so many made poses leave room for an eighth at least.
std::vector<Combination> combinationsOf(const Combination& most, double poses) {
    const std::vector<PoseCounts> lists = candidateKinds(most.listed), pilots = candidateKinds(most.tried);
    std::vector<Combination> out = {{}};
    for (std::size_t k = 1; k < lists.size(); ++k)
        if (const double share = allowedShare(lists[k], poses); share > 0)
            out.push_back({shareOf(lists[k], share), shareOf(pilots[k], share)});
    return out;
}

PoseCounts without(const PoseCounts& counts, bool can_mix) {
    return {counts.sample, can_mix ? counts.mix : 0, can_mix ? counts.cover : 0};
}

PoseCounts least(const PoseCounts& a, const PoseCounts& b) {
    return {std::min(a.sample, b.sample), std::min(a.mix, b.mix), std::min(a.cover, b.cover)};
}

// Tries the combinations, and then half of the best one, unless that is the clips alone.
std::vector<PoseTrial> tryAll(PosePilot& pilot, std::span<const Combination> combinations) {
    std::vector<PoseCounts> kinds;
    for (const Combination& combination : combinations) kinds.push_back(combination.tried);
    const std::vector<std::vector<double>> errors = pilot.errorsOf(kinds);
    std::vector<PoseTrial> trials;
    for (std::size_t k = 0; k < kinds.size(); ++k) trials.push_back({combinations[k].listed, errors[k]});
    const std::size_t best = chooseTrial(trials);
    if (best == 0) return trials;
    const PoseCounts half = shareOf(kinds[best], 0.5);
    pilot.setMade(half);
    trials.push_back({shareOf(trials[best].counts, 0.5), pilot.errorsOf(std::span(&half, 1)).front()});
    return trials;
}

}  // namespace

AutoChoice chooseAutoPoses(const AutoInput& input, const AutoOptions& wanted, int threads, ProgressStyle progress) {
    const auto start = std::chrono::steady_clock::now();
    AutoChoice choice;
    // 1. Find what may be listed: what the rig can have and the minutes allow.
    std::optional<Progress> bar;
    std::size_t steps = 0;
    const auto step = [&] { bar->update(double(++steps)); };
    const PilotOptions options;
    PosePilot pilot({input.rigs, input.plan, input.options, threads, step}, options);
    choice.folds = pilot.folds();
    choice.pilot_frames = pilot.frames();
    choice.composed = pilot.composed();
    choice.can_mix = pilot.canMix();
    const double minutes_of_pose = minutesOfPose(input, wanted, threads);
    choice.clip_minutes = double(input.plan.candidates.frameCount()) * minutes_of_pose;
    const double poses = wanted.minutes > 0 ? (wanted.minutes - choice.clip_minutes) / minutes_of_pose : kMaxPoses;
    const PoseCounts listed = without(wanted.most, choice.can_mix);
    const Combination most{listed, least(listed, options.made)};
    const std::vector<Combination> combinations = combinationsOf(most, poses);
    // 2. Try it. A fold takes a bake and a fit for each combination, and then a bake and a fit for half of the best.
    if (combinations.size() > 1) {
        pilot.setMade(most.tried);
        bar.emplace(progress, "pilot", "steps", double(choice.folds * (combinations.size() + 3)));
        const std::vector<PoseTrial> trials = tryAll(pilot, combinations);
        choice.chosen = chooseTrial(trials);
        for (const PoseTrial& trial : trials)
            choice.tried.push_back({trial, ratioOf(trial, trials[0]),
                                    choice.clip_minutes + double(trial.counts.total()) * minutes_of_pose});
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    choice.pilot_minutes = seconds.count() / 60;
    return choice;
}

}  // namespace penumbra
