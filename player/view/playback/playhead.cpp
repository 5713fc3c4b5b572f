#include "player/view/playback/playhead.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

// A frame's own time must find that frame, whatever rounding did to it.
constexpr double kTimeTolerance = 1e-9;

double frameSeconds(const AnimationView& animation, const ClipView& clip, std::size_t number) {
    return animation.times[clip.first_frame + number] - animation.times[clip.first_frame];
}

double clipSeconds(const AnimationView& animation, const ClipView& clip) {
    if (clip.frame_count < 2) return 0;
    const std::size_t last = clip.frame_count - 1;
    return 2 * frameSeconds(animation, clip, last) - frameSeconds(animation, clip, last - 1);
}

namespace {

// Brings a time into [0, clipSeconds).
double wrapped(double time, double seconds) {
    if (!(seconds > 0)) return 0;
    const double rest = std::fmod(time, seconds);
    return rest < 0 ? rest + seconds : rest;
}

}  // namespace

std::size_t frameNumber(const AnimationView& animation, const ClipView& clip, double time) {
    const double seconds = clipSeconds(animation, clip);
    if (!(seconds > 0)) return 0;
    const double start = animation.times[clip.first_frame];
    const std::span<const double> times = animation.times.subspan(clip.first_frame, clip.frame_count);
    const auto after = std::upper_bound(times.begin(), times.end(), start + wrapped(time, seconds) + kTimeTolerance);
    return std::size_t(std::max<std::ptrdiff_t>(after - times.begin() - 1, 0));
}

ClipPosition clipPosition(const AnimationView& animation, const ClipView& clip, double time) {
    ClipPosition position;
    position.frame = position.next = frameNumber(animation, clip, time);
    if (position.frame + 1 >= clip.frame_count) return position;
    position.next = position.frame + 1;
    const double start = frameSeconds(animation, clip, position.frame);
    const double span = frameSeconds(animation, clip, position.next) - start;
    const double after = wrapped(time, clipSeconds(animation, clip)) - start;
    if (after > kTimeTolerance && span > 0) position.part = std::min(after / span, 1 - 1e-9);
    return position;
}

double positionSeconds(const AnimationView& animation, const ClipView& clip, double number) {
    const double last = double(clip.frame_count - 1), within = std::clamp(number, 0.0, last);
    const auto frame = std::size_t(within);
    const double start = frameSeconds(animation, clip, frame);
    if (frame + 1 >= clip.frame_count) return start;
    return start + (within - double(frame)) * (frameSeconds(animation, clip, frame + 1) - start);
}

void advance(Playhead& playhead, const AnimationView& animation, const ClipView& clip, double seconds) {
    if (!playhead.playing) return;
    const double round =
        playhead.smooth ? frameSeconds(animation, clip, clip.frame_count - 1) : clipSeconds(animation, clip);
    playhead.time = wrapped(playhead.time + playhead.speed * seconds, round);
}

void stepFrames(Playhead& playhead, const AnimationView& animation, const ClipView& clip, int frames) {
    const std::ptrdiff_t count = clip.frame_count;
    const std::ptrdiff_t next = std::ptrdiff_t(frameNumber(animation, clip, playhead.time)) + frames;
    playhead.playing = false;
    playhead.time = frameSeconds(animation, clip, std::size_t(((next % count) + count) % count));
}

}  // namespace penumbra
