#include "player/view/view_light.h"

#include "player/view/view_cast_way.h"

namespace penumbra {

namespace {

const AssetView& firstAsset(const Scene& scene) { return scene.characters.front()->asset; }

}  // namespace

void advanceLight(Scene& scene, const ViewState& state, double seconds) {
    const AssetView& asset = firstAsset(scene);
    if (asset.lights.empty()) return;
    const bool fades =
        shownShading(scene, state).light_form == LightForm::kRotation && shownCastMode(state) == CastMode::kProduct;
    scene.blend.advance(lightsOf(asset), asset.lights.back().order, state.light, seconds, fades);
}

LightView shownLight(const Scene& scene, const ViewState& state) {
    return scene.blend.active() ? scene.blend.light() : firstAsset(scene).lights[state.light];
}

SkyPicture shownSky(const Scene& scene, const ViewState& state) {
    return scene.blend.active() ? scene.blend.sky() : skyPicture(firstAsset(scene).lights[state.light]);
}

LightKey shownLightKey(const Scene& scene, const ViewState& state) { return {state.light, scene.blend.version()}; }

bool lightHasSuns(const Scene& scene, const ViewState& state) {
    return scene.blend.active() ? scene.blend.hasSuns() : !firstAsset(scene).lights[state.light].suns.empty();
}

void setShownLight(const Scene& scene, const ViewState& state, Character& character) {
    ShadingSet& set = *character.shading;
    if (!scene.blend.active()) {
        if (set.light() != state.light) set.setLight(state.light);
        return;
    }
    const std::size_t last = character.asset.lights.size() - 1;
    if (set.light() == last && character.light_version == scene.blend.version()) return;
    set.replaceLight(last, scene.blend.light());
    character.light_version = scene.blend.version();
}

}  // namespace penumbra
