#include "player/render/render_batch.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/image/exposure.h"
#include "player/draw/picture_view.h"
#include "player/frame/truth_frames.h"
#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

namespace {

bool showsTruth(const Panel& panel) { return needsTruth(panel.channel) || panel.source == VisibilitySource::kTruth; }

}  // namespace

bool BatchPlan::exposes() const {
    const bool png =
        std::any_of(files.begin(), files.end(), [](const auto& file) { return file.extension() == ".png"; });
    return options.channel == Channel::kShaded && (png || !panels.empty() || image_error);
}

void findTruth(BatchPlan& plan) {
    if (!plan.look.truth) return;
    const AssetView &asset = *plan.look.asset, &truth = *plan.look.truth;
    const bool needed = !plan.files.empty() && showsTruth({plan.options.channel, plan.options.source});
    for (const ListedFrame& at : plan.chosen.frames) {
        plan.truth_frames.push_back(findTruthFrame(asset, truth, at.frame));
        if (needed && !plan.truth_frames.back())
            throw InvalidInput(truth.name + ": has no frame " + std::to_string(at.number) + " of clip \"" +
                               std::string(asset.animation.clips[at.clip].name) + "\", or at another time");
    }
}

namespace {

// The pictures of one frame, each drawn when it is first asked for.
class FramePictures {
public:
    FramePictures(OffscreenRenderer& renderer, PosedFrame& frame, const FrameView& view)
        : renderer_(renderer), frame_(frame), view_(view) {}

    const Image& of(const Panel& panel) {
        throwIfInterrupted();
        const auto [at, added] = drawn_.try_emplace(panel);
        if (added && (frame_.hasTruth() || !showsTruth(panel))) at->second = renderer_.draw(panel, frame_, view_);
        return at->second;
    }

private:
    OffscreenRenderer& renderer_;
    PosedFrame& frame_;
    const FrameView& view_;
    std::map<Panel, Image> drawn_;
};

class Batch {
public:
    Batch(const BatchPlan& plan, int threads, BatchResult& result);
    FrameRecord run(std::size_t index, const BatchSink& sink);

private:
    const BatchPlan& plan_;
    PosedFrame frame_;
    std::optional<TruthMean> mean_;
    std::optional<TransferError> transfer_error_;
    std::optional<OffscreenRenderer> renderer_;
    FrameView view_;
    std::optional<std::size_t> framed_clip_;  // clip that view_ frames, for Framing::kClip
    float exposure_ = 1;                      // BatchResult::exposure

    void frameClips(std::span<const std::size_t> clips);
    // Frames the clip of a frame if each clip has a camera of its own.
    void frameClipOf(const ListedFrame& at);
    float chooseExposure();
    void draw(std::size_t index, const BatchSink& sink, FrameRecord& record);
};

Batch::Batch(const BatchPlan& plan, int threads, BatchResult& result) : plan_(plan), frame_(plan.look, threads) {
    if (plan.look.truth && plan.relative_error) mean_ = truthMean(frame_);
    if (plan.look.truth && transferErrorOrder(*plan.look.asset, *plan.look.truth) >= 1)
        transfer_error_.emplace(*plan.look.asset, *plan.look.truth);
    result.mean_from_truth = mean_ && mean_->from_truth;
    if (!plan.draws()) return;
    if (plan.framing == Framing::kClips) frameClips(plan.chosen.clips);
    renderer_.emplace(plan.options, plan.look);
    result.gl = renderer_->gl();
    result.path = renderer_->path();
    if (plan.exposes()) exposure_ = chooseExposure();
    renderer_->setExposure(exposure_);
    result.exposure = exposure_;
}

void Batch::frameClips(std::span<const std::size_t> clips) {
    view_ = makeSequenceView(plan_.options, *plan_.look.asset, boundsOfClips(frame_, clips));
}

void Batch::frameClipOf(const ListedFrame& at) {
    if (plan_.framing != Framing::kClip || framed_clip_ == at.clip) return;
    framed_clip_ = at.clip;
    frameClips({&at.clip, 1});
}

float Batch::chooseExposure() {
    const RenderOptions& options = plan_.options;
    if (options.exposure) return *options.exposure;
    const AssetView& asset = *plan_.look.asset;
    const ListedFrame& first = plan_.chosen.first;
    std::optional<std::size_t> truth_frame;
    if (plan_.look.truth) truth_frame = findTruthFrame(asset, *plan_.look.truth, first.frame);
    frameClipOf(first);
    frame_.pose(first.frame, truth_frame);
    if (plan_.framing == Framing::kFrame) view_ = makePictureView(options, asset, frame_.positions());
    const VisibilitySource source = truth_frame ? VisibilitySource::kTruth : VisibilitySource::kModel;
    return automaticExposure(renderer_->drawWithoutOverlays({Channel::kShaded, source}, frame_, view_));
}

void Batch::draw(std::size_t index, const BatchSink& sink, FrameRecord& record) {
    const RenderOptions& options = plan_.options;
    if (plan_.framing == Framing::kFrame) view_ = makePictureView(options, *plan_.look.asset, frame_.positions());
    FramePictures pictures(*renderer_, frame_, view_);
    if (!plan_.files.empty()) {
        record.file = plan_.files[index];
        Image picture = pictures.of({options.channel, options.source});
        if (options.light_background && plan_.look.shaded) putBehind(picture, renderer_->drawSky(view_));
        sink.picture(index, picture);
    }
    std::vector<Image> panels;
    for (const Panel& panel : plan_.panels) panels.push_back(pictures.of(panel));
    if (!panels.empty()) sink.panels(index, std::move(panels));
    if (!plan_.image_error || !frame_.hasTruth()) return;
    record.image = imageError(pictures.of({options.channel, VisibilitySource::kModel}),
                              pictures.of({options.channel, VisibilitySource::kTruth}), exposure_,
                              plan_.flip ? ImageMetrics::kRmseAndFlip : ImageMetrics::kRmse, frame_.threads());
}

FrameRecord Batch::run(std::size_t index, const BatchSink& sink) {
    FrameRecord record{plan_.chosen.frames[index]};
    if (renderer_) frameClipOf(record.at);
    frame_.pose(record.at.frame, plan_.truth_frames.empty() ? std::nullopt : plan_.truth_frames[index]);
    record.out_of_range = frame_.evaluator().outOfRange();
    if (frame_.hasTruth())
        record.errors = errorsOf(frame_, mean_ ? &*mean_ : nullptr, transfer_error_ ? &*transfer_error_ : nullptr);
    if (renderer_) draw(index, sink, record);
    return record;
}

}  // namespace

BatchResult runBatch(const BatchPlan& plan, int threads, const BatchSink& sink) {
    BatchResult result;
    Batch batch(plan, threads, result);
    if (sink.exposure) sink.exposure(result.exposure);
    for (std::size_t i = 0; i < plan.chosen.frames.size(); ++i) {
        throwIfInterrupted();
        result.frames.push_back(batch.run(i, sink));
        sink.progress(i + 1);
    }
    return result;
}

}  // namespace penumbra
