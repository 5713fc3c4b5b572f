#include "player/render/frame_errors.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/frame/truth_frames.h"
#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

namespace {

std::vector<double> storedMean(const AssetView& asset) {
    std::vector<double> mean;
    std::vector<float> decoded;
    for (const ClusterView& cluster : asset.model.clusters) {
        decoded.resize(cluster.mean.count);
        decode(cluster.mean, decoded);
        mean.insert(mean.end(), decoded.begin(), decoded.end());
    }
    return mean;
}

// Returns the larger of the two, or NaN if either is: std::max() drops a NaN, and then a gate would pass it.
double largerOrNan(double a, double b) { return a > b || std::isnan(a) ? a : b; }

}  // namespace

TruthMean truthMean(PosedFrame& frame) {
    const Shot& shot = frame.shot();
    TruthMean mean;
    mean.coefficients.resize(shot.asset->mesh.positions.size() * std::size_t(shot.asset->model.stride));
    double frames = 0;
    for (const ClipView& clip : shot.asset->animation.clips) {
        if (clip.held_out) continue;
        for (std::size_t f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f) {
            throwIfInterrupted();
            const std::optional<std::size_t> truth_frame = findTruthFrame(*shot.asset, *shot.truth, f);
            if (!truth_frame) continue;
            frame.pose(f, truth_frame);
            const std::vector<float>& coefficients = frame.vertices(VisibilitySource::kTruth).coefficients;
            for (std::size_t i = 0; i < coefficients.size(); ++i) mean.coefficients[i] += coefficients[i];
            ++frames;
        }
    }
    mean.from_truth = frames > 0;
    if (!mean.from_truth && !hasVisibility(*shot.asset))
        throw InvalidInput(shot.truth->name + ": has no frame of a training clip, whose mean relative errors need");
    if (!mean.from_truth) return {storedMean(*shot.asset), false};
    for (double& number : mean.coefficients) number /= frames;
    return mean;
}

void ErrorSums::add(const ErrorSums& other) {
    frames += other.frames;
    vertices += other.vertices;
    ambient += other.ambient;
    ambient_max = largerOrNan(ambient_max, other.ambient_max);
    squares += other.squares;
    variation += other.variation;
    transfer += other.transfer;
    tail.add(other.tail);
}

double ErrorSums::rmsV() const { return std::sqrt(squares / double(vertices) / (4 * std::numbers::pi)); }

double ErrorSums::relativeError() const { return std::sqrt(squares / variation); }

ErrorSums errorsOf(PosedFrame& frame, const TruthMean* mean, const TransferError* transfer) {
    ErrorSums sums;
    sums.frames = 1;
    const std::vector<float>& e = frame.ambient(VisibilitySource::kModel);
    const std::vector<float>& e_truth = frame.ambient(VisibilitySource::kTruth);
    sums.vertices = e.size();
    for (std::size_t v = 0; v < e.size(); ++v) {
        const double difference = std::abs(double(e[v]) - e_truth[v]);
        sums.ambient += difference;
        sums.ambient_max = largerOrNan(sums.ambient_max, difference);
        sums.tail.add(difference);
    }
    sums.transfer = std::numeric_limits<double>::quiet_NaN();
    if (transfer) {
        sums.transfer = 0;
        for (const float error : transfer->of(frame)) sums.transfer += double(error);
    }
    const std::span<const float> model = frame.coefficients(VisibilitySource::kModel);
    const std::span<const float> truth = frame.coefficients(VisibilitySource::kTruth);
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double difference = double(model[i]) - truth[i];
        sums.squares += difference * difference;
        if (!mean) continue;
        const double variation = truth[i] - mean->coefficients[i];
        sums.variation += variation * variation;
    }
    if (!mean) sums.variation = std::numeric_limits<double>::quiet_NaN();
    return sums;
}

}  // namespace penumbra
