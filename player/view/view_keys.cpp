#include "player/view/view_keys.h"

#include "player/papers/transfer/transfer_model.h"
#include "player/view/view_look.h"

namespace penumbra {

PoseKey poseKey(const Scene& scene, const ViewState& state, std::size_t index) {
    const Character& character = *scene.characters[index];
    PoseKey key;
    if (state.characters[index].still) key.file_pose = character.file_pose;
    const std::size_t first = character.asset.animation.clips[state.characters[index].clip].first_frame;
    const ClipPosition position = shownPosition(state, scene, index);
    key.frame = first + position.frame;
    key.next = first + (position.part > 0 ? position.next : position.frame);
    key.part = position.part;
    if (state.inspect.score_edit && state.inspect.score_edit->character == index) key.edited = state.inspect.score_edit;
    if (state.inspect.weight_edit && state.inspect.weight_edit->character == index)
        key.weights = state.inspect.weight_edit;
    return key;
}

FrameKey frameKey(const Scene& scene, const ViewState& state) {
    FrameKey key{state, scene.blend.version(), scene.fieldVersion()};
    for (const auto& character : scene.characters) {
        const CharacterTimeline& timeline = character->timeline;
        key.figures += timeline.figures.out_of_range.size() + timeline.figures.errors.size();
        key.figures += timeline.components.key() ? 1 : 0;
    }
    return key;
}

CastMode shownCastMode(const ViewState& state) {
    const bool cast = state.show.shadows == Shadows::kBoth || state.show.shadows == Shadows::kCast;
    const bool joins = state.show.channel == Channel::kShaded || state.show.channel == Channel::kAmbient ||
                       state.show.channel == Channel::kError;
    return cast && joins && !state.show.component ? state.show.cast_mode : CastMode::kProduct;
}

Channel shownChannel(const Scene& scene, const ViewState& state, std::size_t index) {
    const Character& character = *scene.characters[index];
    if (state.show.component) return Channel::kShaded;
    const Channel wished = state.show.channel;
    const bool missing = (wished == Channel::kError && !*character.posed.truth_frame) ||
                         (wished == Channel::kParts && !character.asset.model.composition) ||
                         (wished == Channel::kBouncedAmbient && !character.asset.model.indirect);
    return missing ? Channel::kAmbient : wished;
}

ShadingChoice shownShading(const Scene& scene, const ViewState& state) {
    ShadingChoice choice = state.lighting.shading;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const AssetView& asset = scene.characters[i]->asset;
        if (!scene.characters[i]->shown.shading) continue;
        if (!hasForm(asset.lights[state.lighting.light], choice.light_form)) choice.light_form = LightForm::kRotation;
        for (const std::size_t material : state.characters[i].material_of_slot)
            if (!hasReflectance(asset.materials[material], choice.reflectance))
                choice.reflectance = Reflectance::kSlices;
    }
    return choice;
}

bool groundCasts(const Scene& scene, const ViewState& state) {
    return state.show.ground && scene.ground_file && !scene.field && scene.ground_file->casts &&
           shownCastMode(state) == CastMode::kProduct &&
           (state.show.shadows == Shadows::kBoth || state.show.shadows == Shadows::kCast);
}

bool sendsLight(const Scene& scene, const ViewState& state) {
    return scene.passesLight() && state.show.channel == Channel::kShaded && !state.show.component &&
           state.show.shadows == Shadows::kBoth && state.lighting.bounces != Bounces::kDirect &&
           shownCastMode(state) == CastMode::kProduct &&
           (groundCasts(scene, state) || (scene.cast->casterCount() > 0 && scene.characters.size() > 1));
}

bool changesCoefficients(const Scene& scene, std::size_t index, const CoefficientsKey& key) {
    const Character& character = *scene.characters[index];
    if (key.shadows == Shadows::kSelf || !hasVisibility(character.asset)) return false;
    const std::size_t itself = character.caster == kNobody ? 0 : 1;
    return key.shadows != Shadows::kBoth || scene.field || key.on_ground || scene.cast->casterCount() > itself;
}

namespace {

Stance stanceOf(const Character& character) { return {character.posed.pose(), character.posed.to_scene}; }

// Shadows of others that join in another way than as a product join later.
Shadows shadowsOfCoefficients(Shadows shadows, CastMode mode) {
    if (mode == CastMode::kProduct) return shadows;
    return shadows == Shadows::kBoth ? Shadows::kSelf : Shadows::kNone;
}

GroundKey groundKey(const Scene& scene, const ViewState& state, const LookKey& look, bool on_cpu) {
    const ShowChoice& show = state.show;
    GroundKey key;
    key.seen.shadows = show.shadows == Shadows::kBoth ? Shadows::kCast : show.shadows;
    key.on_cpu = on_cpu;
    key.seen.mode = look.mode;
    key.seen.on_ground = groundCasts(scene, state);
    key.field = scene.fieldVersion();
    key.suns = look.suns;
    key.lit = scene.characters.front()->shown.shading && show.channel == Channel::kShaded && !show.component;
    if (key.lit) {
        key.light = look.light;
        key.rotation = lightRotation(state);
    }
    if (scene.ground_file && !scene.ground_file->material.empty()) key.eye = toFloat(cameraPosition(state.camera));
    return key;
}

}  // namespace

ViewKeys keysOf(const Scene& scene, const ViewState& state, bool field_on_cpu) {
    ViewKeys keys;
    LookKey look;
    look.lighting = state.lighting;
    look.shading = shownShading(scene, state);
    look.light = shownLightKey(scene, state);
    look.suns = showsSuns(scene, state);
    look.mode = shownCastMode(state);
    keys.ground = groundKey(scene, state, look, field_on_cpu);
    std::vector<Stance>& casters = keys.ground.seen.casters;
    for (const auto& character : scene.characters) {
        keys.suns.everyone.push_back(stanceOf(*character));
        if (character->caster != kNobody) casters.push_back(keys.suns.everyone.back());
    }
    keys.suns.field = scene.fieldVersion();
    keys.suns.light = look.light;
    keys.suns.rotation = lightRotation(state);
    keys.received.wanted = sendsLight(scene, state);
    const bool on_ground = keys.ground.seen.on_ground;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const std::optional<PickedVertex>& picked = state.inspect.picked;
        CharacterKey& key = keys.characters.emplace_back();
        key.coefficients = {
            keys.suns.everyone[i], shadowsOfCoefficients(state.show.shadows, look.mode), look.mode, on_ground, {}, 0};
        if (look.mode != CastMode::kProduct || changesCoefficients(scene, i, key.coefficients)) {
            key.coefficients.casters = casters;
            key.coefficients.field = scene.fieldVersion();
        }
        key.look = look;
        key.look.material_of_slot = state.characters[i].material_of_slot;
        key.look.turn = key.coefficients.own.to_scene.linear();
        key.channel = shownChannel(scene, state, i);
        key.compare = shownCompare(state);
        key.component = state.show.component;
        if (key.compare == Compare::kDifference) key.gain = state.show.difference_gain;
        if (picked && picked->character == i) key.picked = picked->vertex;
        if (key.channel == Channel::kShaded && !key.component) key.eye = toFloat(cameraPosition(state.camera));
        if (!keys.received.wanted) continue;
        keys.received.coefficients.push_back(key.coefficients);
        keys.received.looks.push_back(key.look);
        keys.received.eye = key.eye;
    }
    return keys;
}

}  // namespace penumbra
