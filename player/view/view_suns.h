#pragma once
// When the suns of the light shine as such in the window.
#include <string_view>

#include "player/view/view_scene.h"

namespace penumbra {

// Says why suns cannot shine, for example "the light has no suns"; empty where they can.
std::string_view whyNoSuns(const Scene& scene, const ViewState& state);
// Tells whether they shine: the user wants them, nothing is in their way, and the picture has shaded colours.
bool showsSuns(const Scene& scene, const ViewState& state);

}  // namespace penumbra
