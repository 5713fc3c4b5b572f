#pragma once
// The panels beside the picture and what the mouse does in it. Dear ImGui, between ViewWindow::beginPanels() and
// drawPanels(); they change the state only.
#include "player/view/view_painter.h"

namespace penumbra {

// Figures of the frame before.
struct ViewFigures {
    EvaluationPath path = EvaluationPath::kCpu;
    UpdateCost update;
    PaintCost paint;
    double gpu = 0;  // milliseconds, GpuTimer; of no meaning in software
    bool software = true;
    double frame = 0;     // milliseconds from frame to frame while frames follow one another
    std::string message;  // of the last thing that went wrong, or was written
};

// `unit`: ImGui coordinates per 1/96 inch. `picture` in ImGui coordinates.
void buildPanels(const Scene& scene, ViewState& state, const ViewFigures& figures, const Rectangle& picture,
                 float unit);

// Drags and the wheel over the picture: left orbits, middle or Shift + left pans, right or Ctrl + left turns the light.
void applyMouse(const Scene& scene, ViewState& state, const Rectangle& picture);

}  // namespace penumbra
