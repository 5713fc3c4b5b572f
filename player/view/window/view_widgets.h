#pragma once
// The parts of the window's panels. They draw by Dear ImGui within a window of it, and change nothing but the state.
#include <string>

#include "player/view/folder_list.h"
#include "player/view/view_controls.h"
#include "player/view/view_layout.h"

namespace penumbra {

constexpr unsigned kMarked = 0xff4dbff2;  // the colour of what is not as usual, as ImU32

// Adds a line of a list, and returns true when it is clicked. `width` 0: as wide as the panel.
bool listLine(const std::string& name, std::size_t id, bool chosen, float width = 0);

// Says something beside the pointer, in lines of a readable length.
void tooltip(const char* text);

// Draws the controls of a panel by Dear ImGui, in the order of the table. `width` is that of a menu or a slider that
// has a line of its own; below 0: up to the right edge.
void drawControls(ControlPanel panel, const Scene& scene, ViewState& state, float width = -1);

// Tells what an asset holds.
void assetPanel(const Character& character);
// Shows the numbers of the picked vertex, the model's beside the truth's.
void vertexPanel(const Scene& scene, const PickedVertex& picked);
// Lists the factors of the visibility of a picked vertex of a composed character, each with its E, and lets the user
// choose whose lobe is drawn.
void factorPanel(const Scene& scene, ViewState& state);
// Shows the components of its cluster: scores under sliders, ranges, and shares of the variance over training frames.
void componentPanel(const Scene& scene, ViewState& state);

// Draws names, scales, tangent frames and figures of the picked vertex over the picture. Call this between
// ViewWindow::beginPanels() and drawPanels(). `picture` is in ImGui's coordinates.
void drawOverlays(const Scene& scene, const ViewState& state, const Rectangle& picture);

// Writes what has happened last at the lower edge of the picture.
void drawMessage(const std::string& message, const Rectangle& picture);
// Says how to begin.
void drawHint(const Rectangle& picture);

// Shows the files that were opened last and those of a folder; a click chooses one, or another folder.
void filePanel(const FolderList& list, ViewState& state);

// Builds what is under the picture: play, speed, time; a bar that scrubs; and a strip for each figure of the clip's
// frames.
void buildTimeline(const Scene& scene, ViewState& state);

}  // namespace penumbra
