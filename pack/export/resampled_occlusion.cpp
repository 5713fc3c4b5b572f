// Frames at a steady rate from those of a bake.
#include <algorithm>
#include <cmath>

#include "pack/export/occlusion_source.h"

namespace penumbra {

namespace {

// A frame of the result: the part `share` of the way from one frame to the next one of its clip.
struct BetweenFrames {
    std::size_t first = 0, second = 0;
    float share = 0;
};

template <class Number>
std::vector<Number> blended(const std::vector<Number>& a, const std::vector<Number>& b, float share) {
    std::vector<Number> out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] * (1 - share) + b[i] * share;
    return out;
}

class ResampledOcclusion : public OcclusionSource {
public:
    ResampledOcclusion(std::unique_ptr<OcclusionSource> from, double rate) : from_(std::move(from)) {
        mesh_ = from_->mesh();
        rest_normals_ = from_->restNormals();
        frames_.clip_names = from_->frames().clip_names;
        for (std::size_t begin = 0; begin < from_->frames().frameCount();) begin = sampleClip(begin, rate);
    }
    bool hasBounces() const override { return from_->hasBounces(); }

    OcclusionFrame read(std::size_t frame, FrameParts parts, int threads) const override {
        const BetweenFrames& at = between_[frame];
        OcclusionFrame a = from_->read(at.first, parts, threads);
        if (at.share == 0) return a;
        const OcclusionFrame b = from_->read(at.second, parts, threads);
        return {blended(a.ambient, b.ambient, at.share), blended(a.bent, b.bent, at.share),
                blended(a.bounced, b.bounced, at.share)};
    }

private:
    std::unique_ptr<OcclusionSource> from_;
    std::vector<BetweenFrames> between_;  // [F]

    // Samples the clip whose first frame is `begin`. Returns the first frame of the next one.
    std::size_t sampleClip(std::size_t begin, double rate) {
        const FrameList& known = from_->frames();
        std::size_t end = begin + 1;
        while (end < known.frameCount() && known.clip[end] == known.clip[begin]) ++end;
        const double start = known.time[begin], duration = known.time[end - 1] - start;
        const auto count = std::size_t(std::floor(duration * rate * (1 + 1e-9) + 1e-6)) + 1;
        for (std::size_t i = 0, at = begin; i < count; ++i) {
            const double time = std::min(start + double(i) / rate, known.time[end - 1]);
            while (at + 1 < end && known.time[at + 1] <= time) ++at;
            const std::size_t next = std::min(at + 1, end - 1);
            const double step = known.time[next] - known.time[at];
            between_.push_back({at, next, step > 0 ? float((time - known.time[at]) / step) : 0.0f});
            frames_.clip.push_back(known.clip[begin]);
            frames_.time.push_back(start + double(i) / rate);
        }
        return end;
    }
};

}  // namespace

std::unique_ptr<OcclusionSource> resampledOcclusion(std::unique_ptr<OcclusionSource> source, double rate) {
    return std::make_unique<ResampledOcclusion>(std::move(source), rate);
}

bool hasSteadyRate(const FrameList& frames) {
    for (std::size_t f = 2; f < frames.frameCount(); ++f) {
        if (frames.clip[f] != frames.clip[f - 2]) continue;
        const double step = frames.time[f - 1] - frames.time[f - 2];
        if (!(std::abs(frames.time[f] - frames.time[f - 1] - step) <= 1e-3 * step)) return false;
    }
    return true;
}

double meanRate(const FrameList& frames) {
    double seconds = 0, steps = 0;
    for (std::size_t f = 1; f < frames.frameCount(); ++f) {
        if (frames.clip[f] != frames.clip[f - 1]) continue;
        seconds += frames.time[f] - frames.time[f - 1];
        steps += 1;
    }
    return seconds > 0 ? steps / seconds : 0;
}

}  // namespace penumbra
