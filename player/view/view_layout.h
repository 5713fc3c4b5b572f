#pragma once
// Tells where things are in the window, in pixels from the top left corner.
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

struct Rectangle {
    int x = 0, y = 0, width = 0, height = 0;
};

// The room that the panels take of a window. In a small window they leave most of it to the picture.
struct PanelSizes {
    float side = 0, timeline = 0;  // width of the panel at the left, height of the one below
};
// `width` and `height` are those of the window, and `unit` 1/96 inch, all in the same coordinates.
PanelSizes panelSizes(float width, float height, float unit);

// Returns what the panels leave of a window of width x height pixels, at least 1 x 1. `scale` is pixels a unit.
Rectangle pictureArea(int width, int height, float scale);

// A part of the picture with its own view of the scene. `clip` is the part of `area` that is drawn.
struct Pane {
    Shown shown = Shown::kModel;
    Rectangle area, clip;
};
std::vector<Pane> panesOf(const ViewState& state, const Rectangle& picture);

}  // namespace penumbra
