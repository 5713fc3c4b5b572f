#pragma once
// Figures of every frame of a clip, computed a few at a time between the frames of a window.
#include <optional>

#include "player/runtime/evaluator.h"

namespace penumbra {

class ClipStrip {
public:
    // Starts anew when it is another animation or clip. `evaluator` loses its pose: not the one that is drawn.
    void compute(Evaluator& evaluator, std::size_t clip, double milliseconds);
    // Evaluator::outOfRange() of the clip's first frames, as many as are known.
    std::size_t clip() const { return clip_; }
    std::span<const float> outOfRange() const { return out_of_range_; }

private:
    const AssetView* asset_ = nullptr;
    std::size_t clip_ = 0;
    std::vector<float> out_of_range_;
};

}  // namespace penumbra
