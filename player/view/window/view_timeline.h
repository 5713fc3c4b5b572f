#pragma once
#include "player/view/view_scene.h"

namespace penumbra {

// Builds what is under the picture: play, speed, time; a bar that scrubs; and a strip for each figure of the clip's
// frames. It draws by Dear ImGui within its window, and changes nothing but the state.
void buildTimeline(const Scene& scene, ViewState& state);

}  // namespace penumbra
