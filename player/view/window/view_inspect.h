#pragma once
#include "player/view/view_scene.h"

namespace penumbra {

// Panels about what an asset holds. They draw by Dear ImGui within a window, and change nothing but the state.
void assetPanel(const Character& character);
// Shows the numbers of the picked vertex, the model's beside the truth's.
void vertexPanel(const Scene& scene, const PickedVertex& picked);
// Lists the factors of the visibility of a picked vertex of a composed character, each with its E, and lets the user
// choose whose lobe is drawn.
void factorPanel(const Scene& scene, ViewState& state);
// Shows the components of its cluster: scores under sliders, ranges, and shares of the variance over training frames.
void componentPanel(const Scene& scene, ViewState& state);

}  // namespace penumbra
