#include "player/view/view_scene.h"

#include <algorithm>
#include <cstdio>

#include "player/frame/framed_rest.h"
#include "player/frame/truth_frames.h"
#include "player/view/vertex_figures.h"
#include "player/view/view_controls.h"
#include "player/view/view_look.h"

namespace penumbra {

namespace {

bool anyOf(const Scene& scene, auto test) {
    return std::ranges::any_of(scene.characters, [&](const auto& character) { return test(*character); });
}

}  // namespace

bool Scene::hasTruth() const {
    return anyOf(*this, [](const Character& character) { return character.truth != nullptr; });
}
bool Scene::composed() const {
    return anyOf(*this, [](const Character& character) { return character.asset.model.composition.has_value(); });
}
bool Scene::bounces() const {
    return anyOf(*this, [](const Character& character) { return character.asset.model.indirect.has_value(); });
}
bool Scene::passesLight() const {
    return shaded() &&
           ((cast->casterCount() > 0 && characters.size() > 1) || (ground_file && !field && ground_file->casts));
}
bool Scene::hasOutlines() const {
    return composed() ||
           anyOf(*this, [](const Character& character) { return character.casts == CasterKind::kSpheres; });
}

std::size_t Scene::components() const {
    std::size_t most = 0;
    for (const auto& character : characters) most = std::max(most, mostComponents(character->asset.model));
    return most;
}

ViewState stateFor(const Scene& scene, const ViewState& old) {
    ViewState state = old;
    state.characters.resize(scene.characters.size());
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const AssetView& asset = scene.characters[i]->asset;
        CharacterChoice& choice = state.characters[i];
        if (choice.clip >= asset.animation.clips.size()) choice.clip = 0;
        if (choice.material_of_slot.size() == asset.slot_material.size()) continue;
        choice.material_of_slot.assign(asset.slot_material.begin(), asset.slot_material.end());
    }
    if (state.selected >= scene.characters.size()) state.selected = 0;
    state.slot = std::min(state.slot, state.characters[state.selected].material_of_slot.size());
    if (state.lighting.light >= scene.light_names.size()) state.lighting.light = 0;
    std::erase_if(state.lighting.parameters, [&](const auto& of) {
        if (of.first >= scene.material_names.size()) return true;
        const std::optional<ChangingParameter> range = shownRange(scene, of.first);
        return !range || of.second < range->least || of.second > range->most;
    });
    if (!hasChannel(scene, state.show.channel)) state.show.channel = Channel::kAmbient;
    if (!scene.hasTruth()) state.show.compare = Compare::kModel;
    if (!hasCastMode(scene, state.show.cast_mode)) state.show.cast_mode = CastMode::kProduct;
    if (state.show.component && *state.show.component >= scene.components()) state.show.component.reset();
    state.frame_all = true;
    state.inspect = {};
    state.tool.stroke.reset();
    state.tool.brush.on &= scene.field != nullptr;
    return state;
}

ViewState carriedOver(const Scene& from, const Scene& to, const ViewState& old) {
    const auto moved = [](const std::vector<std::string_view>& names, std::size_t at,
                          const std::vector<std::string_view>& now) -> std::optional<std::size_t> {
        if (at >= names.size()) return std::nullopt;
        const auto found = std::ranges::find(now, names[at]);
        if (found == now.end()) return std::nullopt;
        return std::size_t(found - now.begin());
    };
    ViewState state = old;
    for (CharacterChoice& character : state.characters)
        for (std::size_t& material : character.material_of_slot) {
            const std::optional<std::size_t> now = moved(from.material_names, material, to.material_names);
            if (!now) {
                character.material_of_slot.clear();
                break;
            }
            material = *now;
        }
    state.lighting.light = moved(from.light_names, old.lighting.light, to.light_names).value_or(0);
    state.lighting.parameters.clear();
    for (const auto& [material, value] : old.lighting.parameters)
        if (const auto now = moved(from.material_names, material, to.material_names))
            state.lighting.parameters[*now] = value;
    return state;
}

const VisibilityFactor* shownFactor(const Scene& scene, const ViewState& state) {
    if (!state.inspect.picked) return nullptr;
    const std::vector<VisibilityFactor>& factors = *scene.characters[state.inspect.picked->character]->posed.factors;
    const auto found = std::ranges::find(factors, state.inspect.factor, &VisibilityFactor::choice);
    return found != factors.end() ? &*found : factors.empty() ? nullptr : &factors.front();
}

std::optional<std::size_t> truthFrameOf(const Character& character, const PoseKey& pose) {
    if (!character.truth || pose.part > 0 || pose.file_pose || pose.weights) return std::nullopt;
    return findTruthFrame(character.asset, *character.truth, pose.frame);
}

std::string_view whyNoTruth(const Scene& scene, const ViewState& state) {
    if (!scene.hasTruth()) return "no baked truth is open (F2)";
    bool clip_has = false;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const Character& character = *scene.characters[i];
        const ClipView& clip = character.asset.animation.clips[state.characters[i].clip];
        if (truthFrameOf(character, poseKey(scene, state, i))) return {};
        clip_has |= character.truth && hasTruthOf(character.asset, *character.truth, clip);
    }
    return clip_has ? "no baked truth of this pose" : "no baked truth of this clip";
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
    const ClipView& clip = selectedClip(state, scene);
    std::string text = "clip " + std::string(clip.name) + ", frame " +
                       frameText(shownPosition(state, scene, state.selected)) + ", " +
                       (state.show.component ? "component " + std::to_string(*state.show.component)
                                             : std::string(nameOf(state.show.channel))) +
                       ", " + std::string(nameOf(shownCompare(state)));
    const bool wants_truth =
        shownCompare(state) != Compare::kModel || (state.show.channel == Channel::kError && !state.show.component);
    if (const std::string_view problem = whyNoTruth(scene, state); wants_truth && !problem.empty())
        text += ", " + std::string(problem);
    const bool shaded = state.show.channel == Channel::kShaded && !state.show.component;
    if (shaded)
        text += ", material " + std::string(scene.material_names[chosenMaterial(state)]) + parameterText(scene, state) +
                ", light " + std::string(scene.light_names[state.lighting.light]);
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
    if (shaded && state.lighting.bounces != Bounces::kBoth && (scene.bounces() || scene.passesLight()))
        text += state.lighting.bounces == Bounces::kDirect ? ", direct light" : ", bounced light";
    if (state.show.shadows != Shadows::kBoth) text += ", " + std::string(nameOf(state.show.shadows));
    if (const CastMode mode = shownCastMode(state); mode != CastMode::kProduct)
        text += ", shadows of others by " + std::string(nameOf(mode));
    if (const VisibilityFactor* factor = shownFactor(scene, state))
        text += ", lobe of vertex " + std::to_string(state.inspect.picked->vertex) + " (" +
                nameOf(scene.characters[state.inspect.picked->character]->asset, factor->choice) + ")";
    if (state.show.boxes && scene.hasOutlines()) text += ", boxes of fields";
    if (state.inspect.score_edit)
        text += ", scores of cluster " + std::to_string(state.inspect.score_edit->cluster) + " changed";
    return text;
}

namespace {

BoundingBox boundsOf(const Scene& scene, bool rest) {
    BoundingBox all;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const Character& character = *scene.characters[i];
        const bool posed = character.posed.truth_frame.key() && !rest;
        const BoundingBox box =
            posed ? framedBox(character.asset, character.posed.vertices.positions) : restBox(character.asset);
        std::array<Vec3, 8> corners;
        for (std::size_t c = 0; c < corners.size(); ++c)
            corners[c] = (posed ? character.posed.to_scene : character.placement)
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
