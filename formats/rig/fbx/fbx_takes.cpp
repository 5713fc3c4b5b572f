#include "formats/rig/fbx/fbx_takes.h"

#include <algorithm>
#include <cassert>

#include "formats/rig/rig_keys.h"
#include "formats/rig/rig_matrix.h"

namespace penumbra {

std::optional<FbxSpan> spanOfKeys(const FbxScan& scan, int take, FbxCurves curves) {
    std::optional<FbxSpan> span;
    for (const FbxTrack& track : scan.tracks) {
        if (track.take != take) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::optional<FbxCurve>& curve = track.curves[axis];
            if (!curve || (axis > 0 && curves == FbxCurves::kFirstOfEach)) continue;
            if (!span) span = FbxSpan{curve->first(), curve->last()};
            span->first = std::min(span->first, curve->first());
            span->last = std::max(span->last, curve->last());
        }
    }
    return span;
}

std::optional<FbxSpan> spanOfClip(const FbxScan& scan, int take) {
    const std::optional<FbxSpan> keys = spanOfKeys(scan, take, FbxCurves::kAll);
    const FbxTake& said = scan.takes[std::size_t(take)];
    if (!keys || !said.stop) return keys;
    const double start = said.start.value_or(0);
    const FbxSpan span{std::max(keys->first, start), std::min(keys->last, *said.stop)};
    return *said.stop > start && span.last > span.first ? span : keys;
}

namespace {

// Keys of `width` numbers each, which are quaternions or not.
struct FbxKeys {
    std::vector<double>& times;
    std::vector<float>& values;
    Interpolation interpolation;
    bool rotates;

    std::vector<float> key(std::size_t k) const {
        const std::size_t width = values.size() / times.size();
        const auto first = values.begin() + std::ptrdiff_t(k * width);
        return {first, first + std::ptrdiff_t(width)};
    }
    std::vector<float> at(double time) const {
        const KeySpan span = findKeys(times, time);
        if (span.fraction == 0 || interpolation == Interpolation::kStep) return key(span.from);
        std::vector<float> a = key(span.from), b = key(span.to);
        if (rotates) {
            const Quaternion q = slerp({a[0], a[1], a[2], a[3]}, {b[0], b[1], b[2], b[3]}, span.fraction);
            return {float(q[0]), float(q[1]), float(q[2]), float(q[3])};
        }
        for (std::size_t i = 0; i < a.size(); ++i) a[i] = float(a[i] + span.fraction * (double(b[i]) - a[i]));
        return a;
    }
};

void cutKeys(FbxKeys keys, double first, double last) {
    assert(keys.interpolation != Interpolation::kCubicSpline);
    std::vector<double> times;
    std::vector<float> values;
    const auto add = [&](double time) {
        const std::vector<float> value = keys.at(time);
        times.push_back(time - first);
        values.insert(values.end(), value.begin(), value.end());
    };
    constexpr double kSameKey = 1e-5;  // seconds
    add(first);
    for (const double time : keys.times)
        if (time > first + kSameKey && time < last - kSameKey) add(time);
    add(last);
    keys.times = std::move(times);
    keys.values = std::move(values);
}

}  // namespace

void cutClip(RigSource& source, std::size_t clip, double first, double last) {
    for (Channel& channel : source.clips[clip].channels)
        cutKeys({channel.times, channel.values, channel.interpolation, channel.path == Channel::Path::kRotation}, first,
                last);
    for (MorphChannel& morph : source.morphs)
        if (morph.clip == int(clip)) cutKeys({morph.times, morph.values, morph.interpolation, false}, first, last);
    source.clips[clip].duration = last - first;
}

int framesASecond(const FbxScan& scan) {
    constexpr int kFrames24 = 11, kFrames30 = 6, kFrames30Drop = 7;  // FbxTime::EMode
    if (scan.time_mode == kFrames24) return 24;
    return scan.time_mode == kFrames30 || scan.time_mode == kFrames30Drop ? 30 : 60;
}

bool hasOtherRate(const FbxScan& scan) {
    constexpr int kSame[] = {0, 1, 3, 6, 7, 11};  // default, 120, 60, 30, 30, 24
    return !scan.takes.empty() && std::find(std::begin(kSame), std::end(kSame), scan.time_mode) == std::end(kSame);
}

}  // namespace penumbra
