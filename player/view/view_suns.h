#pragma once
// When the suns of the light shine as such in the window, and what the light is without them.
#include <string_view>
#include <vector>

#include "player/view/view_scene.h"

namespace penumbra {

// Says why suns cannot shine, for example "a material has no lobes"; empty where they can.
std::string_view whyNoSuns(const Scene& scene, const ViewState& state);
// Tells whether they shine: the user wants them, nothing is in their way, and the picture has shaded colours.
bool showsSuns(const Scene& scene, const ViewState& state);

// Returns the suns of the light as it is turned, in the scene.
std::vector<Sun> sunsOf(const LightView& light, const Mat3& rotation);
// Returns the SH of the light without its suns, [n^2, 3].
std::vector<float> remainderOf(const LightView& light);

}  // namespace penumbra
