#pragma once
// Light that characters and a level ground send to one another, in the window.
#include "player/view/view_scene.h"

namespace penumbra {

// Computes what everyone receives, unless that is there already. Everyone must have numbers, materials and lights as
// the keys say. ReceivedLight::version tells what was computed. Returns whether anything was.
bool updateReceived(Scene& scene, const ViewState& state, const ViewKeys& keys, int threads);

}  // namespace penumbra
