// Computes a frame of the window.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "player/frame/truth_frames.h"
#include "player/papers/transfer/transfer_model.h"
#include "player/view/playback/clip_figures.h"
#include "player/view/playback/morph_weights.h"
#include "player/view/vertex_figures.h"
#include "player/view/view_cast.h"
#include "player/view/view_look.h"
#include "player/view/view_received.h"

namespace penumbra {

namespace {

double elapsedMilliseconds(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

Shot shotOf(const Character& character) {
    Shot shot;
    shot.asset = &character.asset;
    shot.frame = character.posed.pose().frame;
    shot.truth = character.truth;
    shot.truth_frame = character.posed.truth_frame->value_or(0);
    return shot;
}

void editScores(Evaluator& evaluator, const ScoreEdit& edit) {
    const std::span<const float> scores = evaluator.scores(edit.cluster);
    std::vector<float> sum(scores.begin(), scores.end());
    for (std::size_t k = 0; k < std::min(sum.size(), edit.added.size()); ++k) sum[k] += edit.added[k];
    evaluator.setScores(edit.cluster, sum);
}

// Gives the pose that was set last other weights of morph targets. `pose` are its numbers where the model reads them.
void setWeights(Evaluator& evaluator, const WeightEdit& edit, std::span<const float> pose) {
    const std::span<const Affine> bones = evaluator.bones();
    const WeightedPose weighted =
        withWeights(evaluator.asset(), {{bones.begin(), bones.end()}, {pose.begin(), pose.end()}}, edit.weights);
    evaluator.setPose(weighted.bones, weighted.pose);
}

// Poses a character, by a pose of a file or else where it is in its clip. Returns whether the pose is another one.
bool poseCharacter(Character& character, const PoseKey& key, int threads) {
    CharacterPose& posed = character.posed;
    return posed.truth_frame.update(key, [&](std::optional<std::size_t>& truth_frame) {
        if (key.file_pose) {
            posed.evaluator->setPose(key.file_pose->bones, key.file_pose->rotations);
        } else if (PositionInterpolation* positions = posed.position_interpolation.get()) {
            positions->evaluate(key.frame, key.next, key.part);
            posed.evaluator->setPositions(positions->points(), positions->inputs());
        } else {
            posed.interpolation->evaluate(key.frame, key.next, key.part);
            posed.evaluator->setPose(posed.interpolation->bones(), posed.interpolation->pose());
        }
        if (key.weights)
            setWeights(*posed.evaluator, *key.weights,
                       key.file_pose ? std::span<const float>(key.file_pose->rotations) : posed.interpolation->pose());
        if (key.edited) editScores(*posed.evaluator, *key.edited);
        skinFrame(*posed.evaluator, threads, posed.vertices);
        truth_frame = truthFrameOf(character, key);
    });
}

// Returns where a posed character stands: as the file places it, moved by the user, and on the ground below its pose.
Affine placeOf(const Scene& scene, std::size_t index, Vec3 moved) {
    const Character& character = *scene.characters[index];
    Affine place = character.placement;
    for (int axis = 0; axis < 3; ++axis) place.m[std::size_t(4 * axis + 3)] += moved[axis];
    if (const SceneCharacter* member = memberOf(scene, index))
        place.m[7] += standingHeight(*member, character.posed.vertices.positions, place, scene.ground_file,
                                     scene.field ? &scene.field->heights() : nullptr);
    return place;
}

// Returns whether the pose is another one.
bool poseInScene(Scene& scene, std::size_t index, const ViewState& state, int threads) {
    Character& character = *scene.characters[index];
    const bool posed = poseCharacter(character, poseKey(scene, state, index), threads);
    const Affine place = placeOf(scene, index, state.characters[index].moved);
    if (!posed && character.posed.to_scene == place) return false;
    character.posed.to_scene = place;
    takeOver(scene, character);
    return posed;
}

// Evaluates the numbers that are missing. Returns whether any were.
bool needCoefficients(const Scene& scene, std::size_t index, const CoefficientsKey& key, bool model, bool truth,
                      int threads) {
    Character& character = *scene.characters[index];
    CharacterPose& posed = character.posed;
    bool made = model && posed.coefficients.update(key, [&](auto&) {
        evaluateSkinned(*posed.evaluator, threads, posed.vertices);
        evaluateIndirect(*posed.evaluator, threads, posed.vertices.indirect);
        posed.hidden = {};
        applyShadows(scene, index, key, threads, {posed.vertices.coefficients, posed.vertices.indirect}, &posed.hidden);
    });
    if (truth && *posed.truth_frame)
        made |= posed.truth_coefficients.update(key, [&](std::vector<float>& coefficients) {
            coefficients = truthCoefficients(shotOf(character), posed.vertices, threads);
            applyShadows(scene, index, key, threads, {coefficients, {}});
        });
    return made;
}

bool setShading(const Scene& scene, Character& character, const ViewState& state, const LookKey& key) {
    CharacterLook& shown = character.shown;
    if (!shown.shading) return false;
    return shown.look.update(key, [&](auto&) {
        if (shown.shading->choice() != key.shading && hasVisibility(character.asset))
            shown.shading = makeShading(scene, character.asset, key.shading);
        ShadingSet& set = *shown.shading;
        for (std::size_t slot = 0; slot < set.slotCount(); ++slot) {
            const std::size_t material = key.material_of_slot[slot];
            // A membrane from another file cannot be on a one-sided mesh, nor a material that is not diffuse on
            // transfer.
            if (set.materialOfSlot()[slot] != material && set.hasMaterial(material)) set.setMaterial(slot, material);
        }
        setParameters(scene, state, set);
        setShownLight(scene, state, set);
        if (set.sunsOn() != key.suns) set.setSuns(key.suns);
        set.setBounces(key.lighting.bounces);
        const Mat3 rotation = transposed(key.turn) * lightRotation(state);  // in the model's frame
        if (set.lightRotation() != rotation) set.setLightRotation(rotation);
    });
}

std::vector<Vec3> valuesOf(Scene& scene, std::size_t index, const ViewState& state, const CharacterKey& key, bool truth,
                           int threads) {
    if (key.coefficients.mode != CastMode::kProduct) return joinedValues(scene, index, state, key, truth, threads);
    Character& character = *scene.characters[index];
    const Affine& place = key.coefficients.own.to_scene;
    const Vec3 eye = transposed(place.linear()) * (key.eye - place.translation());
    FrameVertices& vertices = character.posed.vertices;
    std::vector<float>& baked = *character.posed.truth_coefficients;
    std::vector<float> true_ambient;
    if (key.channel == Channel::kError) true_ambient = ambientOf(shotOf(character), baked, threads);
    // The truth has the same local frames and other numbers, so the numbers are swapped for a while.
    if (truth) std::swap(vertices.coefficients, baked);
    std::vector<Vec3> values = channelValues(shotOf(character), key.channel, character.shown.shading.get(), vertices,
                                             true_ambient, eye, threads);
    if (truth) std::swap(vertices.coefficients, baked);
    return values;
}

void noteError(CharacterLook& shown) {
    shown.mean_error = shown.max_error = 0;
    const std::span<const Vec3> values = shown.of(Shown::kModel);
    for (const Vec3& value : values) {
        shown.mean_error += double(value.x) / double(values.size());
        shown.max_error = std::max(shown.max_error, double(value.x));
    }
}

// Returns the component's effect on E as colours.
std::vector<Vec3> componentValues(Character& character, std::size_t component) {
    character.shown.component.update(component, [&](ComponentEffect& effect) {
        effect.ambient = componentAmbient(character.asset.model, character.asset.mesh.positions.size(), component);
        effect.most = 0;
        for (const float e : effect.ambient) effect.most = std::max(effect.most, std::abs(e));
    });
    const ComponentEffect& effect = *character.shown.component;
    std::vector<Vec3> values;
    for (const float e : effect.ambient) values.push_back(divergingColor(e, effect.most));
    return values;
}

// Computes what is shown. A frame without truth shows its model wherever truth is asked for.
bool showValues(Scene& scene, std::size_t index, const ViewState& state, const CharacterKey& key, int threads) {
    Character& character = *scene.characters[index];
    const bool has_truth = character.posed.truth_frame->has_value();
    return character.shown.values.update(key, [&](auto& values) {
        auto& [model, truth, difference] = values;
        if (key.component) {
            model = componentValues(character, *key.component);
            return;
        }
        if (key.compare != Compare::kTruth || !has_truth) model = valuesOf(scene, index, state, key, false, threads);
        if (key.compare != Compare::kModel)
            truth = has_truth ? valuesOf(scene, index, state, key, true, threads) : model;
        if (key.channel == Channel::kError) noteError(character.shown);
        if (key.compare != Compare::kDifference) return;
        difference.resize(model.size());
        for (std::size_t v = 0; v < model.size(); ++v)
            for (int c = 0; c < 3; ++c) difference[v][c] = key.gain * std::abs(model[v][c] - truth[v][c]);
    });
}

}  // namespace

bool updateScene(Scene& scene, const ViewState& state, const UpdateNeeds& needs, UpdateCost& cost) {
    double evaluating = 0;
    bool evaluated = false, shown = false;
    cost.shade = 0;
    auto start = std::chrono::steady_clock::now();
    const auto lap = [&](double& sum) {
        sum += elapsedMilliseconds(start);
        start = std::chrono::steady_clock::now();
    };
    poseField(scene, state);
    for (std::size_t i = 0; i < scene.characters.size(); ++i) evaluated |= poseInScene(scene, i, state, needs.threads);
    ViewKeys keys = keysOf(scene, state, needs.field);
    keys.received.wanted &= needs.values;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        Character& character = *scene.characters[i];
        const CharacterKey& of = keys.characters[i];
        const bool picked = of.picked.has_value();
        const bool truth = of.compare != Compare::kModel || state.show.channel == Channel::kError || picked;
        // Light that bounces or is received is the model's beside the truth, too.
        const bool model = of.compare != Compare::kTruth || !*character.posed.truth_frame ||
                           character.asset.model.indirect || keys.received.wanted;
        const bool on_cpu = needs.values || (needs.casts && changesCoefficients(scene, i, of.coefficients));
        evaluated |= needCoefficients(scene, i, of.coefficients, (on_cpu && model) || picked, truth, needs.threads);
        if (character.posed.evaluator->composed())
            shown |= character.posed.factors.update(
                {of.coefficients.own.pose, of.picked}, [&](std::vector<VisibilityFactor>& factors) {
                    factors.clear();
                    if (picked) factors = visibilityFactors(*character.posed.evaluator, *of.picked);
                });
        lap(evaluating);
        shown |= setShading(scene, character, state, of.look);
        character.shown.channel = of.channel;
        lap(cost.shade);
    }
    if (needs.values) {
        shown |= updateReceived(scene, state, keys, needs.threads);
        lap(evaluating);
        for (std::size_t i = 0; i < scene.characters.size(); ++i) {
            keys.characters[i].received = scene.received.version;
            shown |= showValues(scene, i, state, keys.characters[i], needs.threads);
        }
        keys.ground.received = keys.ground.seen.on_ground ? scene.received.version : 0;
    }
    lap(cost.shade);
    const bool ground = updateGround(scene, state, keys.ground, needs.threads);
    if (ground) cost.ground = elapsedMilliseconds(start);
    if (evaluated) cost.evaluate = evaluating;
    return evaluated || shown || ground;
}

namespace {

void computeComponents(Character& character, std::size_t vertex, double milliseconds) {
    CharacterTimeline& timeline = character.timeline;
    timeline.score_ranges.compute(*timeline.evaluator, milliseconds);
    const std::size_t cluster = clusterAt(character.asset, vertex);
    if (timeline.score_ranges.complete())
        timeline.components.update(cluster, [&](std::vector<ComponentFigures>& components) {
            components = timeline.score_ranges.figures(*timeline.evaluator, cluster);
        });
}

}  // namespace

void computeStrips(Scene& scene, const ViewState& state, double milliseconds) {
    Character& character = *scene.characters[state.selected];
    const std::size_t clip = state.characters[state.selected].clip;
    const auto start = std::chrono::steady_clock::now();
    CharacterTimeline& timeline = character.timeline;
    if (timeline.figures.clip != clip) timeline.figures = {clip, {}, {}};
    computeRanges(*timeline.evaluator, character.asset.animation.clips[clip], milliseconds,
                  timeline.figures.out_of_range);
    const double left = milliseconds - elapsedMilliseconds(start);
    if (character.truth && left > 0)
        timeline.error_strip.compute(*timeline.evaluator, *character.truth, clip, left, timeline.figures.errors);
    if (state.inspect.picked)
        computeComponents(*scene.characters[state.inspect.picked->character], state.inspect.picked->vertex, left);
}

bool stripsAreComplete(const Scene& scene, const ViewState& state) {
    const Character& character = *scene.characters[state.selected];
    const std::size_t clip = state.characters[state.selected].clip;
    const std::size_t frames = character.asset.animation.clips[clip].frame_count;
    const ClipFigures& figures = character.timeline.figures;
    return figures.clip == clip && figures.out_of_range.size() >= frames &&
           (!character.truth || figures.errors.size() >= frames) &&
           (!state.inspect.picked ||
            scene.characters[state.inspect.picked->character]->timeline.score_ranges.complete());
}

}  // namespace penumbra
