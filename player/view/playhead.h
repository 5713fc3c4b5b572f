#pragma once
// Where in an animation a viewer is, and how time moves it: on its sampled frames, where there may be truth, or
// smoothly between them.
#include <cstddef>

#include "formats/asset/asset_file.h"

namespace penumbra {

struct Playhead {
    double time = 0;   // seconds after the clip's first frame
    double speed = 1;  // times the clip's own rate, > 0
    bool playing = false;
    // true: a clip ends at its last frame, which has nothing to go on to; false: it stays there for a while
    bool smooth = false;
};

// Seconds that the clip lasts when it is repeated: to its last frame, and on as long as its last two are apart. 0 for
// a clip of one frame.
double clipSeconds(const AnimationView& animation, const ClipView& clip);
// Seconds from the clip's first frame to its frame `number`.
double frameSeconds(const AnimationView& animation, const ClipView& clip, std::size_t number);
// Number in the clip of the last frame that is not after `time`, which may be outside of the clip: clips repeat.
std::size_t frameNumber(const AnimationView& animation, const ClipView& clip, double time);

// Between two sampled frames of a clip.
struct ClipPosition {
    std::size_t frame = 0, next = 0;  // numbers in the clip; next: the last frame's is the last frame
    double part = 0;                  // of the way to the next, in [0, 1)
    bool operator==(const ClipPosition&) const = default;
};
ClipPosition clipPosition(const AnimationView& animation, const ClipView& clip, double time);
// Seconds from the clip's first frame to `number`, which need not be whole, at most the last frame's.
double positionSeconds(const AnimationView& animation, const ClipView& clip, double number);

// `seconds` of wall clock later; a clip starts again at its end.
void advance(Playhead& playhead, const AnimationView& animation, const ClipView& clip, double seconds);
// To another frame, `frames` later (earlier when negative), round the clip's ends; stops playing.
void stepFrames(Playhead& playhead, const AnimationView& animation, const ClipView& clip, int frames);

}  // namespace penumbra
