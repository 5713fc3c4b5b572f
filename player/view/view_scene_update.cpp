// Computes a frame of the window.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "player/frame/truth_frames.h"
#include "player/view/vertex_figures.h"
#include "player/view/view_cast.h"
#include "player/view/view_cast_way.h"
#include "player/view/view_light.h"
#include "player/view/view_material.h"
#include "player/view/view_scene.h"
#include "player/view/view_suns.h"

namespace penumbra {

namespace {

double elapsedMilliseconds(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

Shot shotOf(const Character& character) {
    Shot shot;
    shot.asset = &character.asset;
    shot.frame = character.frame;
    shot.truth = character.truth;
    shot.truth_frame = character.truth_frame.value_or(0);
    return shot;
}

void editScores(Character& character, const std::optional<ScoreEdit>& edit) {
    character.edited = edit;
    if (!edit) return;
    const std::span<const float> scores = character.evaluator->scores(edit->cluster);
    std::vector<float> sum(scores.begin(), scores.end());
    for (std::size_t k = 0; k < std::min(sum.size(), edit->added.size()); ++k) sum[k] += edit->added[k];
    character.evaluator->setScores(edit->cluster, sum);
}

// Poses a character: by a pose of a file, or else where it is in its clip. Returns false where it has that pose
// already.
bool poseCharacter(Character& character, const BonePose* file_pose, const ClipView& clip, const ClipPosition& position,
                   const std::optional<ScoreEdit>& edit, int threads) {
    const std::size_t frame = clip.first_frame + position.frame;
    if (character.posed && character.shown_pose == file_pose && character.frame == frame &&
        character.part == position.part && character.edited == edit)
        return false;
    if (file_pose) {
        character.evaluator->setPose(file_pose->bones, file_pose->rotations);
    } else if (PositionInterpolation* positions = character.position_interpolation.get()) {
        positions->evaluate(frame, clip.first_frame + position.next, position.part);
        character.evaluator->setPositions(positions->points(), positions->inputs());
    } else {
        PoseInterpolation& pose = *character.interpolation;
        pose.evaluate(frame, clip.first_frame + position.next, position.part);
        character.evaluator->setPose(pose.bones(), pose.pose());
    }
    editScores(character, edit);
    skinFrame(*character.evaluator, threads, character.vertices);
    character.shown_pose = file_pose;
    character.frame = frame;
    character.part = position.part;
    character.truth_frame.reset();
    if (character.truth && position.part == 0 && !file_pose)
        character.truth_frame = findTruthFrame(character.asset, *character.truth, frame);
    character.posed = true;
    character.has_model_numbers = character.has_truth_numbers = false;
    character.factors_of.reset();
    return true;
}

}  // namespace

ShadingChoice shownShading(const Scene& scene, const ViewState& state) {
    ShadingChoice choice = state.shading;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const AssetView& asset = scene.characters[i]->asset;
        if (!scene.characters[i]->shading) continue;
        if (!hasForm(asset.lights[state.light], choice.light_form)) choice.light_form = LightForm::kRotation;
        for (const std::size_t material : state.characters[i].material_of_slot)
            if (!hasReflectance(asset.materials[material], choice.reflectance))
                choice.reflectance = Reflectance::kSlices;
    }
    return choice;
}

bool useShading(Scene& scene, const ViewState& state) {
    const ShadingChoice choice = shownShading(scene, state);
    bool changed = false;
    for (const auto& character : scene.characters) {
        if (!character->shading || character->shading->choice() == choice || character->asset.transfer) continue;
        character->shading = std::make_unique<ShadingSet>(character->asset, choice);
        changed = true;
    }
    return changed;
}

namespace {

void setShading(const Scene& scene, Character& character, const CharacterChoice& choice, const ViewState& state,
                bool suns) {
    if (!character.shading) return;
    ShadingSet& set = *character.shading;
    for (std::size_t slot = 0; slot < set.slotCount(); ++slot) {
        const std::size_t material = choice.material_of_slot[slot];
        // A membrane from another file cannot be on a one-sided mesh, nor a material that is not diffuse on transfer.
        if (set.materialOfSlot()[slot] != material && set.hasMaterial(material)) set.setMaterial(slot, material);
    }
    setParameters(scene, state, set);
    setShownLight(scene, state, character);
    if (set.sunsOn() != suns) set.setSuns(suns);
    set.setBounces(state.bounces);
    const Mat3 rotation = transposed(character.to_scene.linear()) * lightRotation(state);  // in the model's frame
    if (set.lightRotation() != rotation) set.setLightRotation(rotation);
}

// Returns where a posed character stands: as the file places it, moved by the user, and on the ground below its pose.
Affine placeOf(const Scene& scene, std::size_t index, Vec3 moved) {
    const Character& character = *scene.characters[index];
    Affine place = character.placement;
    for (int axis = 0; axis < 3; ++axis) place.m[std::size_t(4 * axis + 3)] += moved[axis];
    if (const SceneCharacter* member = memberOf(scene, index))
        place.m[7] += standingHeight(*member, character.vertices.positions, place, scene.ground_file,
                                     scene.field ? &scene.field->heights() : nullptr);
    return place;
}

// Takes a character to its place. Returns false where it stands there already.
bool placeCharacter(Character& character, const Affine& to_scene) {
    if (character.to_scene == to_scene) return false;
    character.to_scene = to_scene;
    return true;
}

// Forgets numbers that were made for other shadows, or for others in other places.
void forgetNumbers(const Scene& scene, std::size_t index, Shadows shadows) {
    Character& character = *scene.characters[index];
    const bool moved = character.cast_version != scene.cast_version && changesNumbers(scene, index, shadows);
    if (!moved && character.shadows == shadows) return;
    character.has_model_numbers = character.has_truth_numbers = false;
    character.shadows = shadows;
    character.cast_version = scene.cast_version;
}

// Evaluates the numbers that are missing. Returns whether any were.
bool needNumbers(const Scene& scene, std::size_t index, bool model, bool truth, int threads) {
    Character& character = *scene.characters[index];
    const bool needs_model = model && !character.has_model_numbers;
    const bool needs_truth = truth && character.truth_frame && !character.has_truth_numbers;
    if (needs_model) {
        evaluateNumbers(*character.evaluator, threads, character.vertices);
        evaluateIndirect(*character.evaluator, threads, character.vertices.indirect);
        applyShadows(scene, index, character.shadows, threads, character.vertices.numbers, character.vertices.indirect);
        character.has_model_numbers = true;
    }
    if (needs_truth) {
        character.truth_numbers = truthNumbers(shotOf(character), character.vertices, threads);
        applyShadows(scene, index, character.shadows, threads, character.truth_numbers);
        character.has_truth_numbers = true;
    }
    return needs_model || needs_truth;
}

// Evaluates the factors of a vertex of a composed asset, unless they are there. Without a vertex there are none.
void needFactors(Character& character, std::optional<std::size_t> vertex) {
    if (!character.evaluator->composed() || (vertex && character.factors_of == vertex)) return;
    character.factors = vertex ? visibilityFactors(*character.evaluator, *vertex) : std::vector<VisibilityFactor>();
    character.factors_of = vertex;
}

Channel shownChannel(const Character& character, Channel wished) {
    const bool missing = (wished == Channel::kError && !character.truth_frame) ||
                         (wished == Channel::kParts && !character.asset.model.composition) ||
                         (wished == Channel::kBouncedAmbient && !character.asset.model.indirect);
    return missing ? Channel::kAmbient : wished;
}

std::vector<Vec3> valuesOf(Character& character, bool truth, Channel channel, Vec3 eye, int threads) {
    std::vector<float> true_ambient;
    if (channel == Channel::kError) true_ambient = ambientOf(shotOf(character), character.truth_numbers, threads);
    // The truth has the same local frames and other numbers, so the numbers are swapped for a while.
    if (truth) std::swap(character.vertices.numbers, character.truth_numbers);
    std::vector<Vec3> values = channelValues(shotOf(character), channel, character.shading.get(), character.vertices,
                                             true_ambient, eye, threads);
    if (truth) std::swap(character.vertices.numbers, character.truth_numbers);
    return values;
}

void noteError(Character& character) {
    character.mean_error = character.max_error = 0;
    const std::vector<Vec3>& values = character.values[std::size_t(Shown::kModel)];
    for (const Vec3& value : values) {
        character.mean_error += double(value.x) / double(values.size());
        character.max_error = std::max(character.max_error, double(value.x));
    }
}

// Computes what is shown: `values` returns what the model shows, or the truth. A frame without truth shows its model
// wherever truth is asked for.
void showValues(Character& character, Compare compare, const auto& values) {
    const bool has_truth = character.truth_frame.has_value();
    auto& [model, truth, difference] = character.values;
    if (compare != Compare::kTruth || !has_truth) model = values(false);
    if (compare != Compare::kModel) truth = has_truth ? values(true) : model;
    if (character.channel == Channel::kError) noteError(character);
    if (compare != Compare::kDifference) return;
    difference.resize(model.size());
    for (std::size_t v = 0; v < model.size(); ++v)
        for (int c = 0; c < 3; ++c) difference[v][c] = std::abs(model[v][c] - truth[v][c]);
}

// Shows the component's effect on E as colours instead of the channel.
void showComponent(Character& character, std::size_t component) {
    if (character.component != component) {
        character.component_ambient =
            componentAmbient(character.asset.model, character.vertices.positions.size(), component);
        character.component = component;
        character.component_most = 0;
        for (const float e : character.component_ambient)
            character.component_most = std::max(character.component_most, std::abs(e));
    }
    std::vector<Vec3>& values = character.values[std::size_t(Shown::kModel)];
    values.clear();
    for (const float e : character.component_ambient) values.push_back(divergingColor(e, character.component_most));
    character.channel = Channel::kShaded;
}

}  // namespace

namespace {

// Returns whether anything was computed.
bool poseInScene(Scene& scene, std::size_t index, const ViewState& state, const ViewContents& contents, int threads) {
    Character& character = *scene.characters[index];
    const ClipView& clip = character.asset.animation.clips[state.characters[index].clip];
    const bool is_edited = state.score_edit && state.score_edit->character == index;
    const BonePose* const file_pose = state.characters[index].still ? character.file_pose : nullptr;
    const bool posed = poseCharacter(character, file_pose, clip, shownPosition(state, contents, index),
                                     is_edited ? state.score_edit : std::nullopt, threads);
    const bool moved = placeCharacter(character, placeOf(scene, index, state.characters[index].moved));
    if (posed || moved) {
        takeOver(scene, index);
        ++scene.pose_version;
    }
    if (moved) character.has_model_numbers = character.has_truth_numbers = false;  // it may cast nothing itself
    return posed;
}

Vec3 inModel(const Character& character, Vec3 point) {
    return transposed(character.to_scene.linear()) * (point - character.to_scene.translation());
}

}  // namespace

void updateScene(Scene& scene, const ViewState& state, const UpdateNeeds& needs, UpdateCost& cost) {
    const Vec3 eye = toFloat(cameraPosition(state.camera));
    UpdateCost spent;
    const bool suns = showsSuns(scene, state);
    bool evaluated = false;
    auto start = std::chrono::steady_clock::now();
    const ViewContents contents = contentsOf(scene);
    const CastMode mode = shownCastMode(state);
    const Shadows shadows = shadowsOfNumbers(state.shadows, mode);
    poseField(scene, state);
    for (std::size_t i = 0; i < scene.characters.size(); ++i)
        evaluated |= poseInScene(scene, i, state, contents, needs.threads);
    spent.evaluate += elapsedMilliseconds(start);
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        Character& character = *scene.characters[i];
        start = std::chrono::steady_clock::now();
        forgetNumbers(scene, i, shadows);
        const Compare compare = shownCompare(state);
        const bool picked = state.picked && state.picked->character == i;
        const bool truth = compare != Compare::kModel || state.channel == Channel::kError || picked;
        const bool model = compare != Compare::kTruth || !character.truth_frame;
        character.channel = shownChannel(character, state.channel);
        const bool on_cpu = needs.values || (needs.casts && changesNumbers(scene, i, shadows));
        evaluated |= needNumbers(scene, i, (on_cpu && model) || picked, truth, needs.threads);
        if (mode != CastMode::kProduct) needOthers(scene, i, mode, needs.threads);
        needFactors(character, picked ? std::optional(state.picked->vertex) : std::nullopt);
        spent.evaluate += elapsedMilliseconds(start);
        start = std::chrono::steady_clock::now();
        setShading(scene, character, state.characters[i], state, suns);
        character.plain = state.component.has_value();
        if (state.component)
            showComponent(character, *state.component);
        else if (needs.values)
            showValues(character, compare, [&](bool of_truth) {
                return mode != CastMode::kProduct
                           ? joinedValues(scene, i, state, of_truth, needs.threads)
                           : valuesOf(character, of_truth, character.channel, inModel(character, eye), needs.threads);
            });
        spent.shade += elapsedMilliseconds(start);
    }
    start = std::chrono::steady_clock::now();
    const std::uint64_t ground = scene.ground.version;
    updateGround(scene, state, needs.field, needs.threads);
    if (scene.ground.version != ground) cost.ground = elapsedMilliseconds(start);
    cost.shade = spent.shade;
    if (evaluated) cost.evaluate = spent.evaluate;
}

namespace {

void computeComponents(Character& character, std::size_t vertex, double milliseconds) {
    character.score_ranges.compute(*character.strip_evaluator, milliseconds);
    const std::size_t cluster = clusterAt(character.asset.model, vertex);
    if (character.components_of == cluster || !character.score_ranges.complete()) return;
    character.components = character.score_ranges.figures(*character.strip_evaluator, cluster);
    character.components_of = cluster;
}

}  // namespace

void computeStrips(Scene& scene, const ViewState& state, double milliseconds) {
    Character& character = *scene.characters[state.selected];
    const std::size_t clip = state.characters[state.selected].clip;
    const auto start = std::chrono::steady_clock::now();
    character.strip.compute(*character.strip_evaluator, clip, milliseconds);
    const double left = milliseconds - elapsedMilliseconds(start);
    if (character.truth && left > 0)
        character.error_strip.compute(*character.strip_evaluator, *character.truth, clip, left);
    if (state.picked) computeComponents(*scene.characters[state.picked->character], state.picked->vertex, left);
}

bool stripsAreComplete(const Scene& scene, const ViewState& state) {
    const Character& character = *scene.characters[state.selected];
    const ClipView& clip = character.asset.animation.clips[state.characters[state.selected].clip];
    return character.strip.outOfRange().size() >= clip.frame_count &&
           (!character.truth || character.error_strip.errors().size() >= clip.frame_count) &&
           (!state.picked || scene.characters[state.picked->character]->score_ranges.complete());
}

}  // namespace penumbra
