#pragma once
// Draws by ImGui what lies over the picture: names, scales, tangent frames, figures of the picked vertex.
#include "player/view/view_layout.h"

namespace penumbra {

// Call this between ViewWindow::beginPanels() and drawPanels(). `picture` is in ImGui's coordinates.
void drawOverlays(const Scene& scene, const ViewState& state, const Rectangle& picture);

}  // namespace penumbra
