#pragma once
// The panels beside the picture, and what the mouse does in it. They draw by Dear ImGui between
// ViewWindow::beginPanels() and drawPanels(), and change nothing but the state.
#include "player/view/cached.h"
#include "player/view/folder_list.h"
#include "player/view/view_painter.h"

namespace penumbra {

// Figures of the frame before.
struct ViewFigures {
    EvaluationPath path = EvaluationPath::kCpu;
    UpdateCost update;
    PaintCost paint;
    double gpu = 0;  // milliseconds by GpuTimer; no meaning in software
    bool software = true;
    double frame = 0;     // milliseconds from frame to frame while frames follow one another
    std::string message;  // about the last thing that went wrong or was written
    Cached<std::filesystem::path, FolderList> folder;  // contents of state.window.browsed
};

// `unit` is ImGui coordinates per 1/96 inch. `picture` is in ImGui coordinates.
void buildPanels(const Scene& scene, ViewState& state, const ViewFigures& figures, const Rectangle& picture,
                 float unit);

// Draws a bar while a file is read; `share` lies in [0, 1].
void buildReadingPanel(const std::string& file, float share, float unit);

// Fills the window with the list of files where nothing is open yet. `problem` is why the last file did not open.
void buildFirstPanel(const FolderList& list, ViewState& state, const std::string& problem);

// Draws a slider for each morph target of the selected character.
void morphPanel(const Scene& scene, ViewState& state);

// Applies drags and the wheel over the picture: left orbits, middle or Shift + left pans, right or Ctrl + left turns
// the light.
void applyMouse(const Scene& scene, ViewState& state, const Rectangle& picture);

}  // namespace penumbra
