#include "pack/export/weight_tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace penumbra {

namespace {

// A track at one time: the value of each weight, and the slopes on both sides.
struct TrackPoint {
    std::vector<double> value, before, after;  // [M]
};

// Returns the key at or before the time; -1: there is none.
std::ptrdiff_t keyBefore(const WeightTrack& track, float time) {
    return std::upper_bound(track.times.begin(), track.times.end(), time) - track.times.begin() - 1;
}

double numberOf(const WeightTrack& track, std::size_t key, std::size_t part, std::size_t m) {
    if (track.form != TrackForm::kCubic) return double(track.values[key * track.count + m]);
    return double(track.values[(3 * key + part) * track.count + m]);
}

constexpr std::size_t kIn = 0, kValue = 1, kOut = 2;  // parts of a key of a cubic track

// The value and slope between key and key + 1, `s` of the way (0 to 1), of weight m.
std::array<double, 2> between(const WeightTrack& track, std::size_t key, double s, std::size_t m) {
    const double step = double(track.times[key + 1]) - double(track.times[key]);
    if (!(step > 0)) return {numberOf(track, key + 1, kValue, m), 0};
    const double a = numberOf(track, key, kValue, m), b = numberOf(track, key + 1, kValue, m);
    if (track.form == TrackForm::kStep) return {s < 1 ? a : b, 0};
    if (track.form == TrackForm::kLinear) return {a + (b - a) * s, (b - a) / step};
    const double out = numberOf(track, key, kOut, m) * step, in = numberOf(track, key + 1, kIn, m) * step;
    const double s2 = s * s, s3 = s2 * s;
    return {(2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * out + (3 * s2 - 2 * s3) * b + (s3 - s2) * in,
            ((6 * s2 - 6 * s) * (a - b) + (3 * s2 - 4 * s + 1) * out + (3 * s2 - 2 * s) * in) / step};
}

TrackPoint pointOf(const WeightTrack& track, float time) {
    TrackPoint out{std::vector<double>(track.count), std::vector<double>(track.count),
                   std::vector<double>(track.count)};
    if (track.times.empty()) return out;
    const std::ptrdiff_t key = keyBefore(track, time);
    const auto last = std::ptrdiff_t(track.times.size()) - 1;
    for (std::size_t m = 0; m < track.count; ++m) {
        if (key < 0 || key == last) {
            out.value[m] = numberOf(track, std::size_t(std::clamp(key, std::ptrdiff_t(0), last)), kValue, m);
        } else {
            const auto k = std::size_t(key);
            const double s =
                (double(time) - double(track.times[k])) / (double(track.times[k + 1]) - double(track.times[k]));
            const auto [value, slope] = between(track, k, s, m);
            out.value[m] = value;
            out.before[m] = out.after[m] = slope;
        }
        // At a key the slope before it is that of the span that ends there.
        if (key > 0 && track.times[std::size_t(key)] == time)
            out.before[m] = between(track, std::size_t(key - 1), 1, m)[1];
        if (key == 0 && track.times[0] == time) out.before[m] = 0;
    }
    return out;
}

std::vector<float> joinedTimes(const WeightTrack& own, const WeightTrack& linear) {
    std::vector<float> times = linear.times;
    times.insert(times.end(), own.times.begin(), own.times.end());
    // A value jumps at a step, and where a file has two keys at one time.
    for (std::size_t k = 1; k < own.times.size(); ++k)
        if (own.form == TrackForm::kStep || own.times[k] == own.times[k - 1])
            times.push_back(std::nextafter(own.times[k], -std::numeric_limits<float>::infinity()));
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

}  // namespace

WeightTrack joinTracks(const WeightTrack& own, const WeightTrack& linear) {
    WeightTrack out;
    out.form = own.form == TrackForm::kCubic ? TrackForm::kCubic : TrackForm::kLinear;
    out.count = own.count + linear.count;
    out.times = joinedTimes(own, linear);
    for (const float time : out.times) {
        const TrackPoint a = pointOf(own, time), b = pointOf(linear, time);
        const auto put = [&](const std::vector<double>& of_own, const std::vector<double>& of_linear) {
            for (const std::vector<double>* list : {&of_own, &of_linear})
                for (const double number : *list) out.values.push_back(float(number));
        };
        if (out.form == TrackForm::kCubic) put(a.before, b.before);
        put(a.value, b.value);
        if (out.form == TrackForm::kCubic) put(a.after, b.after);
    }
    return out;
}

WeightTrack widened(const WeightTrack& own, std::size_t more) {
    WeightTrack out{own.form, own.count + more, own.times, {}};
    for (std::size_t row = 0; row < own.values.size() / std::max<std::size_t>(1, own.count); ++row) {
        const auto first = own.values.begin() + std::ptrdiff_t(row * own.count);
        out.values.insert(out.values.end(), first, first + std::ptrdiff_t(own.count));
        out.values.resize(out.values.size() + more);
    }
    return out;
}

}  // namespace penumbra
