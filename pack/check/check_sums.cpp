// Turns the sums of a check into its figures.
#include "pack/check/check_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace penumbra {

namespace {

// Uses sum over frames (y - mean)^2 = sum y^2 - 2 mean . sum y + frames |mean|^2.
ErrorFigures errorFigures(std::span<const ClipSums* const> clips, std::span<const double> mean,
                          const CheckMeasured& measured) {
    ErrorFigures figures;
    CheckSums total;
    double variation = 0, second_frames = 0;
    for (const ClipSums* clip : clips) {
        second_frames += double(clip->second_frames);
        figures.frames += clip->frames;
        for (const CheckSums& sums : clip->of_cluster) total.add(sums);
        for (std::size_t i = 0; i < mean.size(); ++i)
            variation += mean[i] * (double(clip->frames) * mean[i] - 2 * clip->truth_sum[i]);
    }
    variation += total.truth_squares;
    const double vertices = double(figures.frames) * double(measured.vertices);
    figures.relative_error = std::sqrt(total.error / variation);
    figures.prediction_difference = std::sqrt(total.prediction / variation);
    figures.rms_v = std::sqrt(total.error / vertices / (4 * std::numbers::pi));
    figures.signal_rms_v = std::sqrt(variation / vertices / (4 * std::numbers::pi));
    const auto relative = [&](double squares, bool was_measured) {
        return was_measured ? std::sqrt(std::max(squares, 0.0) / variation) : std::numeric_limits<double>::quiet_NaN();
    };
    const bool composed = figures.composed = measured.composed;
    const bool spanned = measured.spanned && !composed;
    figures.truncation = relative(total.outside, spanned);
    figures.regression = relative(total.error - total.outside, spanned);
    figures.without_residual = relative(total.without_residual, measured.spanned && composed);
    figures.split = relative(total.split, measured.true_local);
    figures.local = relative(total.local, measured.true_local);
    figures.local_truncation = relative(total.local_outside, measured.true_local && measured.local_spanned);
    figures.local_regression = relative(total.local_regression, measured.true_local && measured.local_spanned);
    figures.sh_truncation = relative(total.sh_outside, true);
    figures.bake_noise = relative(total.noise * double(figures.frames) / second_frames, second_frames > 0);
    figures.unpacked_error = relative(total.unpacked, measured.unpacked);
    figures.unpacked_truncation = relative(total.unpacked_outside, measured.unpacked && spanned);
    figures.packing = relative(total.packing, measured.unpacked);
    figures.ambient_error = total.ambient / vertices;
    return figures;
}

}  // namespace

CheckResult figuresOf(std::span<const ClipSums> clips, std::span<const float> stored_mean,
                      const CheckMeasured& measured) {
    std::vector<const ClipSums*> training, held_out;
    for (const ClipSums& clip : clips)
        if (clip.frames > 0) (clip.held_out ? held_out : training).push_back(&clip);
    std::vector<double> mean(stored_mean.begin(), stored_mean.end());
    CheckResult result;
    result.mean_from_truth = !training.empty();
    if (result.mean_from_truth) {
        std::fill(mean.begin(), mean.end(), 0.0);
        double frames = 0;
        for (const ClipSums* clip : training) {
            frames += double(clip->frames);
            for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += clip->truth_sum[i];
        }
        for (double& m : mean) m /= frames;
    }
    for (const ClipSums& clip : clips) {
        if (clip.frames == 0) continue;
        const ClipSums* one[] = {&clip};
        result.clips.push_back(errorFigures(one, mean, measured));
        result.clips.back().name = clip.name;
        result.clips.back().held_out = clip.held_out;
    }
    if (!training.empty()) result.training = errorFigures(training, mean, measured);
    if (!held_out.empty()) result.held_out = errorFigures(held_out, mean, measured);
    result.training.composed = result.held_out.composed = measured.composed;
    result.training.name = "all training";
    result.held_out.name = "all held out";
    result.held_out.held_out = true;
    return result;
}

}  // namespace penumbra
