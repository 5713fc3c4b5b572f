#include "player/view/playback/clip_figures.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "player/frame/truth_frames.h"

namespace penumbra {

void computeRanges(Evaluator& evaluator, const ClipView& clip, double milliseconds, std::vector<float>& out_of_range) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    while (out_of_range.size() < clip.frame_count &&
           std::chrono::duration<double, std::milli>(Clock::now() - start).count() < milliseconds) {
        evaluator.setFrame(clip.first_frame + out_of_range.size());
        out_of_range.push_back(float(evaluator.outOfRange()));
    }
}

void ErrorStrip::start(const Evaluator& evaluator, const AssetView& truth, std::size_t clip) {
    evaluator_.emplace(evaluator);
    truth_ = &truth;
    clip_ = clip;
    cluster_ = 0;
    const std::size_t vertices = evaluator.vertexCount(), size = vertices * std::size_t(evaluator.asset().model.stride);
    for (std::vector<Vec3>* array : {&vertices_.positions, &vertices_.normals, &vertices_.tangents})
        array->resize(vertices);
    for (std::vector<float>* array : {&vertices_.coefficients, &truth_coefficients_}) array->resize(size);
    for (std::vector<float>* array : {&model_ambient_, &true_ambient_}) array->resize(vertices);
}

void ErrorStrip::startFrame(std::size_t frame) {
    const AssetView& asset = evaluator_->asset();
    truth_frame_ = findTruthFrame(asset, *truth_, frame);
    frame_ = {0, 0, truth_frame_.has_value()};
    sum_ = 0;
    if (truth_frame_) evaluator_->setFrame(frame);
}

void ErrorStrip::addCluster() {
    const AssetView& asset = evaluator_->asset();
    const ModelView& model = asset.model;
    const std::size_t begin = model.clusters[cluster_].first_vertex;
    const std::size_t end = begin + model.clusters[cluster_].vertex_count;
    evaluator_->skin(begin, end, vertices_.positions, vertices_.normals, vertices_.tangents);
    evaluator_->evaluateCluster(cluster_, vertices_.coefficients);
    coefficientsFromTruth(*truth_, *truth_frame_, asset, vertices_.range(begin, end), truth_coefficients_);
    const std::size_t stride = std::size_t(model.stride), count = end - begin;
    const auto ambientTo = [&](std::span<const float> coefficients, std::span<float> e) {
        ambient(asset, coefficients.subspan(begin * stride, count * stride), e.subspan(begin, count));
    };
    ambientTo(vertices_.coefficients, model_ambient_);
    ambientTo(truth_coefficients_, true_ambient_);
    for (std::size_t v = begin; v < end; ++v) {
        const float error = std::abs(model_ambient_[v] - true_ambient_[v]);
        sum_ += double(error);
        frame_.most = std::max(frame_.most, error);
    }
}

void ErrorStrip::compute(const Evaluator& evaluator, const AssetView& truth, std::size_t clip, double milliseconds,
                         std::vector<FrameError>& errors) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    if (!evaluator_ || truth_ != &truth || clip_ != clip || errors.size() != known_) {
        start(evaluator, truth, clip);
        errors.clear();
    }
    const ClipView& view = evaluator_->asset().animation.clips[clip];
    const std::size_t clusters = evaluator_->clusterCount();
    while (errors.size() < view.frame_count &&
           std::chrono::duration<double, std::milli>(Clock::now() - begin).count() < milliseconds) {
        if (cluster_ == 0) startFrame(view.first_frame + errors.size());
        if (truth_frame_) addCluster();
        cluster_ = truth_frame_ ? cluster_ + 1 : clusters;
        if (cluster_ < clusters) continue;
        frame_.mean = float(sum_ / double(evaluator_->vertexCount()));
        errors.push_back(frame_);
        cluster_ = 0;
    }
    known_ = errors.size();
}

}  // namespace penumbra
