#pragma once
// Tells where things are in the window, in pixels from the top left corner.
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

struct Rectangle {
    int x = 0, y = 0, width = 0, height = 0;
};

// Sizes of the panels beside the picture, in units of 1/96 inch.
constexpr int kSidePanelWidth = 290, kTimelineHeight = 120;

// Returns what the panels leave of a window of width x height pixels, at least 1 x 1. `scale` is pixels a unit.
Rectangle pictureArea(int width, int height, float scale);

// A part of the picture with its own view of the scene. `clip` is the part of `area` that is drawn.
struct Pane {
    Shown shown = Shown::kModel;
    Rectangle area, clip;
};
std::vector<Pane> panesOf(const ViewState& state, const Rectangle& picture);

}  // namespace penumbra
