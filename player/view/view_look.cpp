#include "player/view/view_look.h"

#include <algorithm>

#include "formats/image/exposure.h"

namespace penumbra {

namespace {

const AssetView& firstAsset(const Scene& scene) { return scene.characters.front()->asset; }

}  // namespace

void advanceLight(Scene& scene, const ViewState& state, double seconds) {
    const AssetView& asset = firstAsset(scene);
    if (asset.lights.empty()) return;
    const bool fades =
        shownShading(scene, state).light_form == LightForm::kRotation && shownCastMode(state) == CastMode::kProduct;
    if (fades)
        scene.blend.advance(lightsOf(asset), asset.lights.back().order, state.lighting.light, seconds);
    else
        scene.blend.jump(state.lighting.light);
}

LightView shownLight(const Scene& scene, const ViewState& state) {
    return scene.blend.active() ? scene.blend.light() : firstAsset(scene).lights[state.lighting.light];
}

SkyPicture shownSky(const Scene& scene, const ViewState& state) {
    if (scene.blend.active()) return scene.blend.sky();
    const SkyPicture* const picture = scene.backdrops[state.lighting.light];
    return picture ? *picture : skyPicture(firstAsset(scene).lights[state.lighting.light]);
}

LightKey shownLightKey(const Scene& scene, const ViewState& state) {
    return {state.lighting.light, scene.blend.version()};
}

bool lightHasSuns(const Scene& scene, const ViewState& state) {
    return scene.blend.active() ? scene.blend.hasSuns() : !firstAsset(scene).lights[state.lighting.light].suns.empty();
}

std::unique_ptr<ShadingSet> makeShading(const Scene& scene, const AssetView& asset, const ShadingChoice& choice) {
    auto set = std::make_unique<ShadingSet>(asset, choice);
    if (scene.textures) set->showSurface();
    return set;
}

bool showsPictures(const Character& character, const ViewState& state) {
    const ShadingSet* const set = character.shown.shading.get();
    return set && set->showsSurface() && character.shown.channel == Channel::kShaded && !state.show.component &&
           shownCompare(state) != Compare::kDifference && shownCastMode(state) == CastMode::kProduct;
}

void setShownLight(const Scene& scene, const ViewState& state, ShadingSet& set) {
    if (scene.blend.active())
        set.replaceLight(set.asset().lights.size() - 1, scene.blend.light());
    else if (set.light() != state.lighting.light)
        set.setLight(state.lighting.light);
}

std::string_view whyNoSuns(const Scene& scene, const ViewState& state) {
    const ShadingSet* shading = scene.characters.front()->shown.shading.get();
    if (!shading) return "no material or no light";
    if (!lightHasSuns(scene, state)) return "the light has no suns";
    if (state.lighting.bounces == Bounces::kIndirect) return "indirect light has no suns of its own";
    if (shownShading(scene, state).light_form != LightForm::kRotation) return "suns need the exact rotation";
    if (state.show.shadows != Shadows::kBoth) return "suns need all shadows";
    if (state.show.cast_mode != CastMode::kProduct) return "suns need shadows that join as a product";
    return {};
}

bool showsSuns(const Scene& scene, const ViewState& state) {
    return state.lighting.suns && showsShadedColors(scene, state) && whyNoSuns(scene, state).empty();
}

namespace {

const MaterialView& materialOf(const Scene& scene, std::size_t material) {
    return scene.characters.front()->asset.materials[material];  // all characters have the materials of every file
}

}  // namespace

std::optional<ChangingParameter> shownRange(const Scene& scene, std::size_t material) {
    return changingParameter(materialOf(scene, material));
}

double shownParameter(const Scene& scene, const ViewState& state, std::size_t material) {
    const auto chosen = state.lighting.parameters.find(material);
    if (chosen != state.lighting.parameters.end()) return chosen->second;
    const ChangingParameter range = *shownRange(scene, material);
    return double(materialOf(scene, material).lobes[range.lobe].parameters[range.index]);
}

void chooseParameter(const Scene& scene, ViewState& state, std::size_t material, double value) {
    const std::optional<ChangingParameter> range = shownRange(scene, material);
    if (range) state.lighting.parameters[material] = std::clamp(value, range->least, range->most);
}

void setParameters(const Scene& scene, const ViewState& state, ShadingSet& shading) {
    for (const std::uint16_t material : shading.materialOfSlot()) {
        const std::optional<ChangingParameter> range = shownRange(scene, material);
        if (!range || !shading.hasMaterial(material)) continue;
        const double wished = shownParameter(scene, state, material);
        if (shading.lobesOf(material)[range->lobe].parameters[range->index] != float(wished))
            shading.setParameter(material, wished);
    }
}

ExposedLook exposedLook(const Scene& scene, const ViewState& state) {
    ExposedLook look{shownLightKey(scene, state), state.lighting.yaw,  state.lighting.pitch,
                     state.show.ground,           state.lighting.suns, {}};
    look.bounces = state.lighting.bounces;
    for (const CharacterChoice& character : state.characters) look.materials.push_back(character.material_of_slot);
    return look;
}

bool showsShadedColors(const Scene& scene, const ViewState& state) {
    return scene.shaded() && state.show.channel == Channel::kShaded && !state.show.component &&
           shownCompare(state) != Compare::kDifference;
}

void fixExposure(ViewState& state, float exposure) {
    state.display.exposure = std::clamp(exposure, kMinExposure, kMaxExposure);
    state.automatic_exposure = false;
}

}  // namespace penumbra
