#pragma once
// Measures what characters of one asset cost on the GLSL path: milliseconds a frame, and bytes.
#include <optional>

#include "player/draw/model_painter.h"
#include "player/gl/offscreen_target.h"

namespace penumbra {

struct GpuCost {
    std::size_t characters = 0;
    // Times until glFinish returns, so that they include the driver's work and the way there and back. evaluate:
    // upload and evaluation.
    double evaluate = 0, draw = 0;
    // Times that the GPU itself worked, by timer queries. Unset in software, whose answers are wrong.
    std::optional<double> gpu_evaluate, gpu_draw;
    std::size_t bytes_shared = 0, bytes_each = 0;  // sizes of GL buffers: the asset's, and one character's
    std::size_t bytes_uploaded = 0;                // for each frame and character
};

// Measures medians of `runs` frames of `characters`, drawn into `target`. `software` tells whether the current
// context is.
GpuCost measureGpuCost(const std::shared_ptr<GlAsset>& asset, Channel channel,
                       std::span<const PosedCharacter> characters, const FrameView& view, const OffscreenTarget& target,
                       bool software, int runs);

}  // namespace penumbra
