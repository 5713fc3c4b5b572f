#include "player/view/view_exposure.h"

#include <algorithm>

#include "formats/image/exposure.h"
#include "player/view/view_light.h"

namespace penumbra {

ExposedLook exposedLook(const Scene& scene, const ViewState& state) {
    ExposedLook look{shownLightKey(scene, state), state.light_yaw, state.light_pitch, state.ground, state.suns, {}};
    look.bounces = state.bounces;
    for (const CharacterChoice& character : state.characters) look.materials.push_back(character.material_of_slot);
    return look;
}

bool showsShadedColors(const Scene& scene, const ViewState& state) {
    return contentsOf(scene).shaded() && state.channel == Channel::kShaded && !state.component &&
           shownCompare(state) != Compare::kDifference;
}

void fixExposure(ViewState& state, float exposure) {
    state.display.exposure = std::clamp(exposure, kMinExposure, kMaxExposure);
    state.automatic_exposure = false;
}

}  // namespace penumbra
