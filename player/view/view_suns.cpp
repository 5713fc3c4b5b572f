#include "player/view/view_suns.h"

#include "player/view/view_exposure.h"
#include "player/view/view_light.h"

namespace penumbra {

std::string_view whyNoSuns(const Scene& scene, const ViewState& state) {
    const ShadingSet* shading = scene.characters.front()->shading.get();
    if (!shading) return "no material or no light";
    if (!lightHasSuns(scene, state)) return "the light has no suns";
    if (state.bounces == Bounces::kIndirect) return "indirect light has no suns of its own";
    if (shownShading(scene, state).light_form != LightForm::kRotation) return "suns need the exact rotation";
    if (state.shadows != Shadows::kBoth) return "suns need all shadows";
    if (state.cast_mode != CastMode::kProduct) return "suns need shadows that join as a product";
    return {};
}

bool showsSuns(const Scene& scene, const ViewState& state) {
    return state.suns && showsShadedColors(scene, state) && whyNoSuns(scene, state).empty();
}

}  // namespace penumbra
