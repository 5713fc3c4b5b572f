#pragma once
// What is drawn over the picture by ImGui: names, scales, tangent frames, figures of the picked vertex.
#include "player/view/view_layout.h"

namespace penumbra {

// Between ViewWindow::beginPanels() and drawPanels(). `picture` in ImGui's coordinates.
void drawOverlays(const Scene& scene, const ViewState& state, const Rectangle& picture);

}  // namespace penumbra
