#pragma once
// The light of the moment in the window: the one that is chosen, or one on the way to it.
#include <span>

#include "player/view/view_scene.h"

namespace penumbra {

// Returns the lights of the files, without the last one, whose place a blend takes.
inline std::span<const LightView> lightsOf(const AssetView& asset) {
    return std::span(asset.lights).first(asset.lights.empty() ? 0 : asset.lights.size() - 1);
}

// Goes on by `seconds` towards the light that `state` has chosen. Lights in other forms than the exact rotation switch
// at once, as only SH can be mixed. So do those under which shadows of others join in another way than as a product.
void advanceLight(Scene& scene, const ViewState& state, double seconds);

// Those of the last advanceLight(); without a blend those of the chosen light. There must be a light. What is returned
// is valid until the next advanceLight().
LightView shownLight(const Scene& scene, const ViewState& state);
SkyPicture shownSky(const Scene& scene, const ViewState& state);
LightKey shownLightKey(const Scene& scene, const ViewState& state);
// Tells whether the light has suns, also where they have faded at the moment.
bool lightHasSuns(const Scene& scene, const ViewState& state);
// Gives the light to a character's ShadingSet.
void setShownLight(const Scene& scene, const ViewState& state, Character& character);

}  // namespace penumbra
