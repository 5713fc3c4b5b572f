#include "formats/rig/frame_sampling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/joined.h"

namespace penumbra {

namespace {

constexpr double kMaxFrames = 1e7;
constexpr double kSameKey = 1e-5;  // seconds

std::vector<double> frameTimes(const ClipTimes& clip, double fps) {
    const double duration = clip.end - clip.begin;
    if (duration <= 0) return {clip.begin};
    std::vector<double> times;
    if (fps > 0) {
        if (duration * fps > kMaxFrames)
            throw BadOption("fps", std::to_string(fps) + " gives clip '" + clip.name + "' more than 1e7 frames");
        // Files hold times as floats: a clip of 24 frames at 24 a second may end just before its last one.
        const double rounding = std::min(kSameKey, 0.01 / fps);
        for (std::size_t i = 0; double(i) / fps <= duration + rounding; ++i)
            times.push_back(clip.begin + double(i) / fps);
        return times;
    }
    times = clip.keys;
    // One key of two tracks may differ by the rounding of its float.
    const auto same = [](double a, double b) { return b - a < kSameKey; };
    times.erase(std::unique(times.begin(), times.end(), same), times.end());
    return times;
}

const ClipTimes& findClip(const std::vector<ClipTimes>& known, const std::string& name, const std::string& owner) {
    std::vector<std::string> names;
    for (const ClipTimes& clip : known) {
        if (clip.name == name) return clip;
        names.push_back(clip.name);
    }
    throw BadOption("clips", "no clip '" + name + "'; " + owner + " has " + listedNames(names));
}

}  // namespace

FrameList sampleClips(const std::vector<ClipTimes>& known, const std::vector<std::string>& chosen, double fps,
                      const std::string& owner) {
    assert(std::isfinite(fps) && fps >= 0);
    std::vector<std::string> names = chosen;
    if (names.empty())
        for (const ClipTimes& clip : known) names.push_back(clip.name);
    FrameList frames;
    for (const std::string& name : names) {
        if (std::count(names.begin(), names.end(), name) > 1)
            throw BadOption("clips", "'" + name + "' is asked for twice");
        for (const double t : frameTimes(findClip(known, name, owner), fps)) {
            frames.clip.push_back(std::uint16_t(frames.clip_names.size()));
            frames.time.push_back(t);
        }
        frames.clip_names.push_back(name);
    }
    return frames;
}

}  // namespace penumbra
