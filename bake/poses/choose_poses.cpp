// Chooses few poses out of many frames.
//
// Problem: a bake of every frame takes long, and neighbouring frames are nearly alike. Choose `count` frames such
// that every other frame has a chosen one near it. Distance is that of pose_features.h, in rest diagonals.
//
// Naive: take every k-th frame. A pose that the character holds for a second is then baked many times, and a quick
// move not at all. The best choice itself cannot be computed: both the least largest gap (k-center) and the least
// mean gap (k-median) are NP-hard.
//
// Here: two greedy methods that are provably near the best, one for each goal, and random choice to compare with.
// Both keep the distance of every frame to its nearest chosen one and lower it with each choice. So a step costs one
// pass over the frames (farthest), or few passes thanks to Minoux' lazy evaluation (representative). choose_poses.h
// names the papers; docs/formulas.md has no section on this, as nothing is derived.
#include "bake/poses/choose_poses.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "bake/common/random_numbers.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kFramesPerTask = 256;
// Distances are in rest diagonals. Features are floats and resolve about 1e-7 of one, so nearer poses count as equal.
constexpr double kSamePose = 1e-6;
constexpr std::size_t kMaxMedians = 23170;  // 2 GiB of float distances

double squaredDistance(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return sum;
}

// Keeps the squared distance of every frame to the nearest chosen one.
class Gaps {
public:
    Gaps(const PoseFeatures& features, int threads)
        : features_(features), threads_(threads), squared_(features.frames, std::numeric_limits<double>::infinity()) {}

    // Adds a chosen frame. Only distances to this one can lower a gap.
    void choose(std::size_t chosen) {
        throwIfInterrupted();
        const std::span<const float> to = features_.row(chosen);
        const std::size_t tasks = (features_.frames + kFramesPerTask - 1) / kFramesPerTask;
        parallelFor(tasks, threads_, [&](std::size_t task) {
            const std::size_t end = std::min(features_.frames, (task + 1) * kFramesPerTask);
            for (std::size_t f = task * kFramesPerTask; f < end; ++f)
                squared_[f] = std::min(squared_[f], squaredDistance(features_.row(f), to));
        });
    }
    std::size_t farthest() const {
        return std::size_t(std::max_element(squared_.begin(), squared_.end()) - squared_.begin());
    }
    double operator[](std::size_t f) const { return std::sqrt(squared_[f]); }

    // Fills in the gaps that the choice leaves.
    void finish(ChosenPoses& chosen) const {
        chosen.largest_gap = std::sqrt(squared_[farthest()]);
        for (std::size_t f = 0; f < squared_.size(); ++f) chosen.mean_gap += (*this)[f] / double(squared_.size());
    }

private:
    const PoseFeatures& features_;
    int threads_;
    std::vector<double> squared_;
};

// Returns the frame that is nearest to the mean of all features, a start that does not depend on the frames' order.
std::size_t nearestToMean(const PoseFeatures& features) {
    std::vector<double> mean(features.width);
    for (std::size_t f = 0; f < features.frames; ++f)
        for (std::size_t i = 0; i < features.width; ++i) mean[i] += features.row(f)[i] / double(features.frames);
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < features.frames; ++f) {
        double squared = 0;
        for (std::size_t i = 0; i < features.width; ++i) squared += std::pow(features.row(f)[i] - mean[i], 2);
        if (squared < least) {
            least = squared;
            best = f;
        }
    }
    return best;
}

}  // namespace

ChosenPoses chooseFarthest(const PoseFeatures& features, std::size_t count, int threads) {
    assert(features.frames > 0 && count > 0);
    Gaps gaps(features, threads);
    ChosenPoses chosen;
    // Always take the frame with the widest gap, until that gap is none.
    for (std::size_t next = nearestToMean(features); chosen.frames.size() < count; next = gaps.farthest()) {
        const double distance = chosen.frames.empty() ? 0 : gaps[next];
        if (!chosen.frames.empty() && distance < kSamePose) break;
        chosen.frames.push_back(next);
        chosen.distance.push_back(distance);
        gaps.choose(next);
    }
    gaps.finish(chosen);
    return chosen;
}

namespace {
// Keeps the distances of all pairs of frames, and tells how much nearer one more chosen frame would be to the others.
class Medians {
public:
    Medians(const PoseFeatures& features, int threads)
        : frames_(features.frames), distance_(frames_ * frames_), gap_(frames_, 0) {
        parallelFor(frames_, threads, [&](std::size_t a) {
            throwIfInterrupted();
            for (std::size_t b = 0; b < frames_; ++b)
                distance_[a * frames_ + b] = float(std::sqrt(squaredDistance(features.row(a), features.row(b))));
        });
    }
    std::span<const float> row(std::size_t f) const { return std::span(distance_).subspan(f * frames_, frames_); }

    // Returns the frame with the least sum of distances to all others.
    std::size_t first() const {
        std::size_t best = 0;
        for (std::size_t f = 1; f < frames_; ++f)
            if (sum(f) < sum(best)) best = f;
        return best;
    }
    void start(std::size_t f) { std::copy(row(f).begin(), row(f).end(), gap_.begin()); }
    void choose(std::size_t f) {
        for (std::size_t i = 0; i < frames_; ++i) gap_[i] = std::min(gap_[i], row(f)[i]);
    }
    // Returns the sum by which all gaps would shrink if frame f were chosen.
    double gain(std::size_t f) const {
        double gain = 0;
        for (std::size_t i = 0; i < frames_; ++i) gain += double(std::max(0.0f, gap_[i] - row(f)[i]));
        return gain;
    }
    double gap(std::size_t f) const { return double(gap_[f]); }

private:
    std::size_t frames_;
    std::vector<float> distance_, gap_;

    double sum(std::size_t f) const { return std::accumulate(row(f).begin(), row(f).end(), 0.0); }
};

// The queue's order: the greatest gain comes first, and of equals the first frame.
struct Candidate {
    double gain;
    std::size_t frame;
    bool operator<(const Candidate& other) const {
        return gain != other.gain ? gain < other.gain : frame > other.frame;
    }
};
}  // namespace

ChosenPoses chooseRepresentative(const PoseFeatures& features, std::size_t count, int threads) {
    assert(features.frames > 0 && count > 0);
    if (features.frames > kMaxMedians)
        throw BadOption("method", "representative takes at most " + std::to_string(kMaxMedians) + " frames, not " +
                                      std::to_string(features.frames) + "; use fewer frames, or farthest");
    // 1. The first frame is the median of all.
    Medians medians(features, threads);
    Gaps gaps(features, threads);
    ChosenPoses chosen{{medians.first()}, {0}};
    medians.start(chosen.frames[0]);
    gaps.choose(chosen.frames[0]);
    // 2. Gains only shrink as frames are chosen (Minoux 1978). So the queue may hold old gains: a frame whose gain is
    // still the greatest when it is computed anew wins, and nobody has to compute the others.
    std::priority_queue<Candidate> queue;
    for (std::size_t f = 0; f < features.frames; ++f) queue.push({medians.gain(f), f});
    while (chosen.frames.size() < count && !queue.empty()) {
        const Candidate now{medians.gain(queue.top().frame), queue.top().frame};
        queue.pop();
        if (!queue.empty() && now < queue.top()) {
            queue.push(now);
            continue;
        }
        // 3. A frame that equals a chosen one is of no use. Any other frame joins the choice and lowers the gaps.
        const double distance = medians.gap(now.frame);
        if (distance < kSamePose) continue;
        chosen.frames.push_back(now.frame);
        chosen.distance.push_back(distance);
        medians.choose(now.frame);
        gaps.choose(now.frame);
    }
    gaps.finish(chosen);
    return chosen;
}

ChosenPoses chooseRandom(const PoseFeatures& features, std::size_t count, std::uint64_t seed, int threads) {
    assert(count > 0 && count <= features.frames);
    std::vector<std::size_t> order(features.frames);
    std::iota(order.begin(), order.end(), 0);
    shuffle(std::span(order), seed);
    Gaps gaps(features, threads);
    ChosenPoses chosen;
    for (std::size_t i = 0; i < count; ++i) {
        chosen.frames.push_back(order[i]);
        chosen.distance.push_back(i == 0 ? 0 : gaps[order[i]]);
        gaps.choose(order[i]);
    }
    gaps.finish(chosen);
    return chosen;
}

}  // namespace penumbra
