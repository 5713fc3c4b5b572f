#pragma once
#include "player/view/view_scene.h"

namespace penumbra {

// What is under the picture: play, speed, time; a bar that scrubs; a strip a figure of the clip's frames. Dear ImGui,
// within its window; changes the state only.
void buildTimeline(const Scene& scene, ViewState& state);

}  // namespace penumbra
