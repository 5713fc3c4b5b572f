#include "pack/check/check_transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/check/baked_frames.h"
#include "pack/check/check_asset.h"
#include "sh/cosine_product.h"
#include "sh/error_tail.h"
#include "sh/hemisphere_norm.h"

namespace penumbra {

namespace {

// Sums over one clip. The squares are about zero until the mean of the training frames is known.
struct ClipTransfer {
    std::string name;
    bool held_out = true;
    std::size_t frames = 0;
    TransferSums sums;
    double ambient = 0;
    ErrorTail tail;
    std::vector<double> truth;  // [V, n] summed over frames

    void add(const ClipTransfer& other) {
        frames += other.frames;
        sums.add(other.sums);
        ambient += other.ambient;
        tail.add(other.tail);
        truth.resize(other.truth.size());
        for (std::size_t i = 0; i < truth.size(); ++i) truth[i] += other.truth[i];
    }
};

class TransferChecker {
public:
    TransferChecker(const AssetView& asset, const VisibilityReader& truth, int threads);
    void addFrame(std::size_t frame);
    TransferCheck result() const;

private:
    const VisibilityReader& truth_;
    int threads_;
    std::size_t coefficients_, stride_;
    Evaluator evaluator_;
    HemisphereNorm norm_;
    std::optional<CosineProduct> cosine_;  // for truth of visibility
    std::vector<ClipTransfer> clips_;
    std::vector<float> evaluated_, predicted_, transfer_, zeros_;

    void findTransfer(const VisibilityFrame& frame);
    TransferCheckRow rowOf(const ClipTransfer& clip, const std::vector<double>& mean) const;
};

TransferChecker::TransferChecker(const AssetView& asset, const VisibilityReader& truth, int threads)
    : truth_(truth),
      threads_(threads),
      coefficients_(asset.transfer->coefficients()),
      stride_(std::size_t(asset.model.stride)),
      evaluator_(asset),
      norm_(asset.transfer->order) {
    if (truth.header().quantity == kHemisphereVisibility) cosine_.emplace(asset.transfer->order);
    const std::size_t vertices = asset.mesh.positions.size();
    evaluated_.resize(vertices * stride_);
    for (std::vector<float>* array : {&predicted_, &transfer_, &zeros_}) array->resize(vertices * coefficients_);
    for (const std::string& name : truth.header().frames.clip_names) {
        ClipTransfer& clip = clips_.emplace_back();
        clip.name = name;
        clip.truth.resize(vertices * coefficients_);
        for (const ClipView& known : asset.animation.clips)
            if (known.name == name) clip.held_out = known.held_out;
    }
}

void TransferChecker::findTransfer(const VisibilityFrame& frame) {
    const std::size_t stored = truth_.header().coefficientCount();
    for (std::size_t v = 0; v < frame.normals.size(); ++v) {
        const std::span<const float> from = std::span(frame.coefficients).subspan(v * stored, stored);
        const std::span<float> to = std::span(transfer_).subspan(v * coefficients_, coefficients_);
        if (cosine_)
            cosine_->apply(from, frame.normals[v], to);
        else
            std::copy_n(from.begin(), coefficients_, to.begin());
    }
}

void TransferChecker::addFrame(std::size_t number) {
    const VisibilityFrame frame = truth_.readFrame(number);
    ClipTransfer& clip = clips_[truth_.header().frames.clip[number]];
    poseAs(evaluator_, frame);
    parallelFor(evaluator_.clusterCount(), threads_, [&](std::size_t c) { evaluator_.evaluateCluster(c, evaluated_); });
    for (std::size_t v = 0; v < frame.normals.size(); ++v)
        std::copy_n(evaluated_.begin() + std::ptrdiff_t(v * stride_), coefficients_,
                    predicted_.begin() + std::ptrdiff_t(v * coefficients_));
    findTransfer(frame);
    clip.sums.add(compareTransfer(norm_, predicted_, transfer_, zeros_, frame.normals, threads_));
    const double weight = 2 / std::sqrt(std::numbers::pi);
    for (std::size_t v = 0; v < frame.normals.size(); ++v) {
        const double error = weight * std::abs(double(predicted_[v * coefficients_]) - transfer_[v * coefficients_]);
        clip.ambient += error;
        clip.tail.add(error);
    }
    for (std::size_t i = 0; i < transfer_.size(); ++i) clip.truth[i] += double(transfer_[i]);
    ++clip.frames;
}

// sum |t - m|^2 = sum |t|^2 - 2 m . sum t + frames |m|^2.
TransferCheckRow TransferChecker::rowOf(const ClipTransfer& clip, const std::vector<double>& mean) const {
    TransferSums sums = clip.sums;
    for (std::size_t i = 0; i < mean.size(); ++i)
        sums.variance += mean[i] * (double(clip.frames) * mean[i] - 2 * clip.truth[i]);
    TransferCheckRow row{clip.name,
                         clip.held_out,
                         clip.frames,
                         errorsOf(sums),
                         clip.ambient / double(std::max<std::size_t>(sums.count, 1)),
                         clip.tail.quantile(kTailShare),
                         clip.tail.largest()};
    if (mean.empty()) row.errors.relative_error = std::numeric_limits<double>::quiet_NaN();
    return row;
}

TransferCheck TransferChecker::result() const {
    ClipTransfer training, held_out;
    training.name = held_out.name = "all";
    training.held_out = false;
    for (const ClipTransfer& clip : clips_) (clip.held_out ? held_out : training).add(clip);
    std::vector<double> mean;
    if (training.frames > 0)
        for (const double sum : training.truth) mean.push_back(sum / double(training.frames));
    TransferCheck check;
    for (const ClipTransfer& clip : clips_)
        if (clip.frames > 0) check.clips.push_back(rowOf(clip, mean));
    if (training.frames > 0) check.training = rowOf(training, mean);
    if (held_out.frames > 0) check.held_out = rowOf(held_out, mean);
    return check;
}

}  // namespace

void checkTransferFits(const AssetView& asset, const VisibilityHeader& truth) {
    const bool transfer = truth.quantity == kDiffuseTransfer;
    if (!transfer && truth.quantity != kHemisphereVisibility)
        throw InvalidInput("quantity is " + truth.quantity + "; truth is diffuse_transfer or hemisphere_visibility");
    const int needed = asset.transfer->order + (transfer ? 0 : 1);
    if (truth.order < needed)
        throw InvalidInput("sh_order is " + std::to_string(truth.order) + "; transfer of order " +
                           std::to_string(asset.transfer->order) + " needs " + truth.quantity + " of order " +
                           std::to_string(needed));
    checkFits(asset, truth, {});
}

TransferCheck checkTransfer(const AssetView& asset, const VisibilityReader& truth, int threads,
                            const std::function<void(std::size_t)>& progress) {
    checkTransferFits(asset, truth.header());
    TransferChecker checker(asset, truth, threads);
    for (std::size_t f = 0; f < truth.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        checker.addFrame(f);
        progress(f + 1);
    }
    return checker.result();
}

}  // namespace penumbra
