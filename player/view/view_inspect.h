#pragma once
#include "player/view/view_scene.h"

namespace penumbra {

// Panels about what an asset holds: Dear ImGui, within a window; they change the state only.
void assetPanel(const Character& character);
// Numbers of the picked vertex, the model's beside the truth's.
void vertexPanel(const Scene& scene, const PickedVertex& picked);
// The components of its cluster: their scores under sliders, ranges and shares of the variance over training frames.
void componentPanel(const Scene& scene, ViewState& state);

}  // namespace penumbra
