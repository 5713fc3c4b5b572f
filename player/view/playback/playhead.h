#pragma once
// Tells where in an animation a viewer is, and how time moves it: on its sampled frames, where there may be truth, or
// smoothly between them.
#include <cstddef>

#include "formats/asset/asset_file.h"

namespace penumbra {

struct Playhead {
    double time = 0;   // seconds after the clip's first frame
    double speed = 1;  // times the clip's own rate, > 0
    bool playing = false;
    // If true, a clip ends at its last frame, which has nothing to go on to. If false, it stays there for a while.
    bool smooth = false;
    bool operator==(const Playhead&) const = default;
};

// Returns the seconds that a repeated clip lasts: to its last frame, and on for as long as its last two frames are
// apart. 0 for a clip of one frame.
double clipSeconds(const AnimationView& animation, const ClipView& clip);
// Returns the seconds from the clip's first frame to its frame `number`.
double frameSeconds(const AnimationView& animation, const ClipView& clip, std::size_t number);
// Returns the number in the clip of the last frame that is not after `time`. Clips repeat, so `time` may lie outside
// of it.
std::size_t frameNumber(const AnimationView& animation, const ClipView& clip, double time);

// A position between two sampled frames of a clip.
struct ClipPosition {
    std::size_t frame = 0, next = 0;  // numbers in the clip; after the last frame next is the last frame, too
    double part = 0;                  // share of the way to the next, in [0, 1)
    bool operator==(const ClipPosition&) const = default;
};
ClipPosition clipPosition(const AnimationView& animation, const ClipView& clip, double time);
// Returns the seconds from the clip's first frame to `number`, which need not be whole; at most those of the last
// frame.
double positionSeconds(const AnimationView& animation, const ClipView& clip, double number);

// Advances by `seconds` of wall clock. A clip starts again at its end.
void advance(Playhead& playhead, const AnimationView& animation, const ClipView& clip, double seconds);
// Goes `frames` frames on (back when negative), round the clip's ends, and stops playing.
void stepFrames(Playhead& playhead, const AnimationView& animation, const ClipView& clip, int frames);

}  // namespace penumbra
