#include "player/draw/overlay_painter.h"

#include "player/frame/visibility_lobe.h"
#include "runtime/shade/shading.h"

namespace penumbra {

void OverlayPainter::drawLobe(const VisibilityFactor& factor, const Receiver& vertex, float scale,
                              const FrameView& view) {
    const Mat3 frame = toLocalFrame(vertex.normal, vertex.tangent);
    const bool residual = factor.choice.kind == FactorKind::kResidual;
    Shape lobe = residual ? signedLobe(factor.convention, factor.coefficients, frame, vertex.position,
                                       kResidualEnlargement * scale)
                          : visibilityLobe(factor.convention, factor.coefficients, frame, vertex.position, scale);
    residual ? shadeSignedLobe(lobe, view.eye) : shadeLobe(lobe, view.eye);
    if (!lobe_) lobe_.emplace(lobe.triangles, Channel::kShaded);
    gl::Clear(GL_DEPTH_BUFFER_BIT);
    lobe_->draw(view, lobe.positions, lobe.values);
}

void OverlayPainter::drawBoxes(std::span<const BoxEdge> edges, const FrameView& view) {
    const Shape ribbons = edgeRibbons(edges, view.eye);
    if (!boxes_ || edges_ != edges.size()) {
        boxes_.emplace(ribbons.triangles, Channel::kParts);
        edges_ = edges.size();
    }
    boxes_->draw(view, ribbons.positions, ribbons.values);
}

}  // namespace penumbra
