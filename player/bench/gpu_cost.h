#pragma once
// What characters of one asset cost on the GLSL path: milliseconds a frame, bytes.
#include <optional>

#include "player/draw/model_painter.h"
#include "player/gl/offscreen_target.h"

namespace penumbra {

struct GpuCost {
    std::size_t characters = 0;
    // Until glFinish returns, so with the driver's work and the way there and back: upload and evaluation; drawing.
    double evaluate = 0, draw = 0;
    // What the GPU itself worked, by timer queries; unset in software, where their answers are wrong.
    std::optional<double> gpu_evaluate, gpu_draw;
    std::size_t bytes_shared = 0, bytes_each = 0;  // of GL buffers: the asset's, and a character's own
    std::size_t bytes_uploaded = 0;                // a frame and character
};

// Medians of `runs` frames of `characters`, into `target`. `software`: of the current context.
GpuCost measureGpuCost(const std::shared_ptr<GlAsset>& asset, Channel channel,
                       std::span<const PosedCharacter> characters, const FrameView& view, const OffscreenTarget& target,
                       bool software, int runs);

}  // namespace penumbra
