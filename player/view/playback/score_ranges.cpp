#include "player/view/playback/score_ranges.h"

#include <algorithm>
#include <chrono>

namespace penumbra {

namespace {

bool isTraining(const AnimationView& animation, std::size_t frame) {
    bool all_held_out = true;
    for (const ClipView& clip : animation.clips) all_held_out = all_held_out && clip.held_out;
    if (all_held_out) return true;
    for (const ClipView& clip : animation.clips)
        if (frame >= clip.first_frame && frame - clip.first_frame < clip.frame_count) return !clip.held_out;
    return false;
}

}  // namespace

void ScoreRanges::add(const Evaluator& evaluator) {
    ranges_.resize(evaluator.clusterCount());
    for (std::size_t c = 0; c < ranges_.size(); ++c) {
        const std::span<const float> scores = evaluator.scores(c);
        ranges_[c].resize(scores.size());
        for (std::size_t k = 0; k < scores.size(); ++k) {
            Range& range = ranges_[c][k];
            range.least = frames_ == 0 ? scores[k] : std::min(range.least, scores[k]);
            range.most = frames_ == 0 ? scores[k] : std::max(range.most, scores[k]);
            range.sum += double(scores[k]);
            range.square_sum += double(scores[k]) * double(scores[k]);
        }
    }
    ++frames_;
}

void ScoreRanges::compute(Evaluator& evaluator, double milliseconds) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const AnimationView& animation = evaluator.asset().animation;
    while (!complete_ && std::chrono::duration<double, std::milli>(Clock::now() - start).count() < milliseconds) {
        if (isTraining(animation, next_frame_)) {
            evaluator.setFrame(next_frame_);
            add(evaluator);
        }
        complete_ = ++next_frame_ >= animation.frameCount();
    }
}

std::vector<ComponentFigures> ScoreRanges::figures(const Evaluator& evaluator, std::size_t cluster) const {
    if (!complete_) return {};
    const ClusterView& view = evaluator.asset().model.clusters[cluster];
    std::vector<float> basis(view.basis.count);
    decode(view.basis, basis);
    const std::size_t length = view.components() == 0 ? 0 : basis.size() / view.components();
    std::vector<ComponentFigures> figures;
    std::vector<double> energies;
    double all = 0;
    for (std::size_t k = 0; k < view.components(); ++k) {
        const Range& range = ranges_[cluster][k];
        const double mean = range.sum / double(frames_);
        double norm2 = 0;
        for (const float b : std::span(basis).subspan(k * length, length)) norm2 += double(b) * double(b);
        energies.push_back(std::max(0.0, range.square_sum / double(frames_) - mean * mean) * norm2);
        all += energies.back();
        figures.push_back({range.least, range.most, 0});
    }
    for (std::size_t k = 0; k < figures.size(); ++k) figures[k].share = all > 0 ? float(energies[k] / all) : 0;
    return figures;
}

}  // namespace penumbra
