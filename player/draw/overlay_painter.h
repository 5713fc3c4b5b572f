#pragma once
// Draws lobes of visibility, and the boxes of a composed asset's fields, over what is in the bound target.
#include "player/draw/draw_frame.h"
#include "player/frame/field_boxes.h"
#include "player/frame/visibility_factors.h"

namespace penumbra {

class OverlayPainter {
public:
    // Draws a factor of a vertex' visibility in front of everything that is there: it clears the depths. `scale` is the
    // radius of visibility 1; the lobe of a residual is kResidualEnlargement times as large.
    void drawLobe(const VisibilityFactor& factor, const Receiver& vertex, float scale, const FrameView& view);
    void drawBoxes(std::span<const BoxEdge> edges, const FrameView& view);

private:
    std::optional<ValuePainter> lobe_, boxes_;
    std::size_t edges_ = 0;  // edges of the boxes
};

}  // namespace penumbra
