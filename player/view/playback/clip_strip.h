#pragma once
// Computes figures of every frame of a clip, a few at a time between the frames of a window.
#include <optional>

#include "runtime/evaluate/evaluator.h"

namespace penumbra {

class ClipStrip {
public:
    // Starts anew when animation or clip have changed. `evaluator` loses its pose, so it must not be the one that is
    // drawn.
    void compute(Evaluator& evaluator, std::size_t clip, double milliseconds);
    // Returns Evaluator::outOfRange() of the clip's first frames, as many as are known.
    std::size_t clip() const { return clip_; }
    std::span<const float> outOfRange() const { return out_of_range_; }

private:
    const AssetView* asset_ = nullptr;
    std::size_t clip_ = 0;
    std::vector<float> out_of_range_;
};

}  // namespace penumbra
