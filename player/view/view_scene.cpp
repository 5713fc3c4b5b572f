#include "player/view/view_scene.h"

#include <algorithm>
#include <cstdio>

#include "player/view/vertex_figures.h"
#include "player/view/view_cast_way.h"
#include "player/view/view_material.h"
#include "player/view/view_suns.h"

namespace penumbra {

ViewContents contentsOf(const Scene& scene) {
    ViewContents contents;
    for (const auto& character : scene.characters) {
        const bool known = character->error_strip.clip() == character->strip.clip();  // the errors come after the range
        contents.characters.push_back(
            {&character->asset.animation, std::max<std::size_t>(1, character->asset.mesh.slots.size()),
             mostComponents(character->asset.model), character->truth != nullptr, character->strip.clip(),
             character->strip.outOfRange(), known ? character->error_strip.errors() : std::span<const FrameError>(),
             character->asset.model.composition.has_value(), character->casts == CasterKind::kSpheres,
             character->factors, character->asset.model.indirect.has_value()});
    }
    contents.materials = scene.material_names.size();
    contents.lights = scene.light_names.size();
    contents.casters = scene.cast->casterCount();
    contents.heights = scene.field != nullptr;
    if (scene.sphere_cast) contents.sphere_casters = contents.casters;
    return contents;
}

ViewState stateFor(const Scene& scene, const ViewState& old) {
    ViewState state = old;
    const ViewContents contents = contentsOf(scene);
    state.characters.resize(scene.characters.size());
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const AssetView& asset = scene.characters[i]->asset;
        CharacterChoice& choice = state.characters[i];
        if (choice.clip >= asset.animation.clips.size()) choice.clip = 0;
        if (choice.material_of_slot.size() != contents.characters[i].slots) {
            choice.material_of_slot.assign(asset.slot_material.begin(), asset.slot_material.end());
            choice.material_of_slot.resize(contents.characters[i].slots);
        }
    }
    if (state.selected >= scene.characters.size()) state.selected = 0;
    state.slot = std::min(state.slot, contents.characters[state.selected].slots);
    if (state.light >= contents.lights) state.light = 0;
    std::erase_if(state.parameters, [&](const auto& of) {
        if (of.first >= contents.materials) return true;
        const std::optional<ChangingParameter> range = shownRange(scene, of.first);
        return !range || of.second < range->least || of.second > range->most;
    });
    if (!contents.shaded() && state.channel == Channel::kShaded) state.channel = Channel::kAmbient;
    if (!contents.composed() && state.channel == Channel::kParts) state.channel = Channel::kAmbient;
    if (!contents.bounces() && state.channel == Channel::kBouncedAmbient) state.channel = Channel::kAmbient;
    if (!contents.hasTruth()) state.compare = Compare::kModel;
    if (!hasCastMode(contents, state.cast_mode)) state.cast_mode = CastMode::kProduct;
    state.frame_all = true;
    state.picked.reset();
    state.factor = {};
    state.score_edit.reset();
    state.stroke.reset();
    state.brush.on &= contents.heights;
    if (state.component && *state.component >= contents.components()) state.component.reset();
    return state;
}

const VisibilityFactor* shownFactor(const Scene& scene, const ViewState& state) {
    if (!state.picked) return nullptr;
    const std::vector<VisibilityFactor>& factors = scene.characters[state.picked->character]->factors;
    const auto found = std::ranges::find(factors, state.factor, &VisibilityFactor::choice);
    return found != factors.end() ? &*found : factors.empty() ? nullptr : &factors.front();
}

namespace {

std::string_view nameOf(Shadows shadows) {
    static constexpr std::string_view kNames[] = {"all shadows", "shadows on itself", "shadows on others",
                                                  "no shadows"};
    return kNames[std::size_t(shadows)];
}

std::string_view nameOf(Compare compare) {
    static constexpr std::string_view kNames[] = {"model", "truth", "side by side", "wipe", "difference"};
    return kNames[std::size_t(compare)];
}

// Returns "3", or "3.42" between two frames.
std::string frameText(const ClipPosition& position) {
    char text[32];
    std::snprintf(text, sizeof text, position.part > 0 ? "%.2f" : "%.0f", double(position.frame) + position.part);
    return text;
}

// Names the parameter of the chosen material, if that may change.
std::string parameterText(const Scene& scene, const ViewState& state) {
    const std::size_t material = chosenMaterial(state);
    const std::optional<ChangingParameter> range = shownRange(scene, material);
    if (!range) return "";
    char text[64];
    std::snprintf(text, sizeof text, " with %s %.6g", std::string(range->name).c_str(),
                  shownParameter(scene, state, material));
    return text;
}

}  // namespace

std::string describe(const Scene& scene, const ViewState& state) {
    const ViewContents contents = contentsOf(scene);
    const ClipView& clip = selectedClip(state, contents);
    std::string text =
        "clip " + std::string(clip.name) + ", frame " + frameText(shownPosition(state, contents, state.selected)) +
        ", " +
        (state.component ? "component " + std::to_string(*state.component) : std::string(nameOf(state.channel))) +
        ", " + std::string(nameOf(shownCompare(state)));
    const bool shaded = state.channel == Channel::kShaded && !state.component;
    if (shaded)
        text += ", material " + std::string(scene.material_names[chosenMaterial(state)]) + parameterText(scene, state) +
                ", light " + std::string(scene.light_names[state.light]);
    if (shaded && scene.blend.part() < 1) {
        char percent[8];
        std::snprintf(percent, sizeof percent, "%.0f%%", 100 * scene.blend.part());
        text += std::string(" (") + percent + " of the way from " + std::string(scene.light_names[scene.blend.from()]) +
                ")";
    }
    const ShadingChoice shading = shownShading(scene, state);
    if (shaded && shading != ShadingChoice())
        text += std::string(", reflectance ") + std::string(nameOf(shading.reflectance)) + ", light form " +
                std::string(nameOf(shading.light_form));
    if (showsSuns(scene, state)) text += ", suns with shadow maps";
    if (shaded && state.bounces != Bounces::kBoth && contents.bounces())
        text += state.bounces == Bounces::kDirect ? ", direct light" : ", bounced light";
    if (state.shadows != Shadows::kBoth) text += ", " + std::string(nameOf(state.shadows));
    if (const CastMode mode = shownCastMode(state); mode != CastMode::kProduct)
        text += ", shadows of others by " + std::string(nameOf(mode));
    if (const VisibilityFactor* factor = shownFactor(scene, state))
        text += ", lobe of vertex " + std::to_string(state.picked->vertex) + " (" +
                nameOf(scene.characters[state.picked->character]->asset, factor->choice) + ")";
    if (state.boxes && contents.hasOutlines()) text += ", boxes of fields";
    if (state.score_edit) text += ", scores of cluster " + std::to_string(state.score_edit->cluster) + " changed";
    return text;
}

namespace {

BoundingBox boundsOf(const Scene& scene, bool rest) {
    BoundingBox all;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const Character& character = *scene.characters[i];
        const bool posed = character.posed && !rest;
        const BoundingBox box =
            boundsOf(posed ? std::span<const Vec3>(character.vertices.positions) : character.asset.mesh.positions);
        std::array<Vec3, 8> corners;
        for (std::size_t c = 0; c < corners.size(); ++c)
            corners[c] = (posed ? character.to_scene : character.placement)
                             .point({(c & 1 ? box.high : box.low).x, (c & 2 ? box.high : box.low).y,
                                     (c & 4 ? box.high : box.low).z});
        all = i == 0 ? boundsOf(corners) : merged(all, boundsOf(corners));
    }
    return all;
}

}  // namespace

BoundingBox boundsOf(const Scene& scene) { return boundsOf(scene, false); }
BoundingBox restBounds(const Scene& scene) { return boundsOf(scene, true); }

}  // namespace penumbra
