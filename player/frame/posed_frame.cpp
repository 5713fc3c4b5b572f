#include "player/frame/posed_frame.h"

#include <cassert>

#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

PosedFrame::PosedFrame(const Shot& look, int threads) : shot_(look), threads_(threads), evaluator_(*look.asset) {}

void PosedFrame::pose(std::size_t frame, std::optional<std::size_t> truth_frame) {
    shot_.frame = frame;
    shot_.truth_frame = truth_frame.value_or(0);
    has_truth_ = truth_frame.has_value();
    evaluator_.setFrame(frame);
    skinFrame(evaluator_, threads_, vertices_);
    evaluateIndirect(evaluator_, threads_, vertices_.indirect);
    for (Source& source : sources_) source.known = source.ambient_known = false;
}

const FrameVertices& PosedFrame::vertices(VisibilitySource source) {
    assert(source == VisibilitySource::kModel || has_truth_);
    if (within_ != source) {
        sources_[std::size_t(within_)].coefficients.swap(vertices_.coefficients);
        sources_[std::size_t(source)].coefficients.swap(vertices_.coefficients);
        within_ = source;
    }
    Source& wanted = sources_[std::size_t(source)];
    if (wanted.known) return vertices_;
    if (source == VisibilitySource::kModel)
        evaluateSkinned(evaluator_, threads_, vertices_);
    else
        vertices_.coefficients = truthCoefficients(shot_, vertices_, threads_);
    wanted.known = true;
    return vertices_;
}

std::span<const float> PosedFrame::coefficients(VisibilitySource source) {
    return vertices(source).coefficients;  // a swap of vectors keeps their elements where they are
}

const std::vector<float>& PosedFrame::ambient(VisibilitySource source) {
    Source& wanted = sources_[std::size_t(source)];
    if (!wanted.ambient_known) {
        wanted.ambient = ambientOf(shot_, vertices(source).coefficients, threads_);
        wanted.ambient_known = true;
    }
    return wanted.ambient;
}

std::vector<Vec3> PosedFrame::radiance(VisibilitySource source, const ShadingSet& shading, Vec3 eye) {
    std::vector<Vec3> radiance;
    if (source == VisibilitySource::kTruth || !shadeTransfer(evaluator_, shading, threads_, radiance))
        shadeFrame(shading, vertices(source), eye, threads_, radiance);
    return radiance;
}

}  // namespace penumbra
