#include "player/view/playback/clip_strip.h"

#include <chrono>

namespace penumbra {

void ClipStrip::compute(Evaluator& evaluator, std::size_t clip, double milliseconds) {
    using Clock = std::chrono::steady_clock;
    if (asset_ != &evaluator.asset() || clip_ != clip) out_of_range_.clear();
    asset_ = &evaluator.asset();
    clip_ = clip;
    const AnimationView& animation = asset_->animation;
    const ClipView& view = animation.clips[clip];
    const auto start = Clock::now();
    while (out_of_range_.size() < view.frame_count &&
           std::chrono::duration<double, std::milli>(Clock::now() - start).count() < milliseconds) {
        const std::size_t frame = view.first_frame + out_of_range_.size();
        evaluator.setFrame(frame);
        out_of_range_.push_back(float(evaluator.outOfRange()));
    }
}

}  // namespace penumbra
