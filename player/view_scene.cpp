#include "player/view_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "formats/errors.h"
#include "formats/project_map.h"
#include "player/truth_frames.h"
#include "player/visibility_lobe.h"

namespace penumbra {

static bool isCharacter(const AssetView& asset) { return asset.has_mesh && asset.has_model; }

// Every file's materials and lights; the slots of the character's own file keep theirs.
static void gatherLibrary(const Scene& scene, const SceneFile& own, AssetView& asset) {
    asset.slot_material.resize(std::max<std::size_t>(1, asset.mesh.slots.size()));  // the first, where none is said
    asset.materials.clear();
    asset.lights.clear();
    for (const SceneFile& file : scene.files) {
        if (!file.asset) {
            asset.lights.push_back({file.light_name, kPictureLightOrder, file.light_sh});
            continue;
        }
        const AssetView& view = file.asset->view;
        if (&file == &own && !view.materials.empty())  // of none of its own: the scene's first
            for (std::uint16_t& material : asset.slot_material) material += std::uint16_t(asset.materials.size());
        asset.materials.insert(asset.materials.end(), view.materials.begin(), view.materials.end());
        asset.lights.insert(asset.lights.end(), view.lights.begin(), view.lights.end());
    }
}

static void attachTruth(Scene& scene, const AssetView& truth) {
    std::string problem;
    bool fits = false;
    for (const auto& character : scene.characters) try {
            checkTruth(character->asset, truth);
            character->truth = &truth;
            fits = true;
        } catch (const InvalidInput& error) {
            problem = error.what();
        }
    if (!fits) throw InvalidInput(problem);
}

// A row along x, each as wide as the widest and a third more.
static void placeCharacters(Scene& scene) {
    float widest = 0;
    for (const auto& character : scene.characters) {
        const BoundingBox box = boundsOf(character->asset.mesh.positions);
        widest = std::max(widest, box.high.x - box.low.x);
    }
    const float middle = 0.5f * float(scene.characters.size() - 1);
    for (std::size_t i = 0; i < scene.characters.size(); ++i)
        scene.characters[i]->offset = {(float(i) - middle) * 4 / 3 * widest, 0, 0};
}

// `like`: a character of the same file, whose decoded regressors it shares, or null.
static std::unique_ptr<Character> makeCharacter(const Scene& scene, const SceneFile& file, const Character* like) {
    auto character = std::make_unique<Character>();
    character->file_bytes = file.asset->file.bytes().size();
    character->asset = file.asset->view;
    if (character->asset.animation.clips.empty()) throw InvalidInput(character->asset.name + ": holds no clip");
    gatherLibrary(scene, file, character->asset);
    character->evaluator =
        like ? std::make_unique<Evaluator>(*like->evaluator) : std::make_unique<Evaluator>(character->asset);
    character->strip_evaluator = std::make_unique<Evaluator>(*character->evaluator);
    character->interpolation = std::make_unique<PoseInterpolation>(character->asset);
    if (!character->asset.materials.empty() && !character->asset.lights.empty())
        character->shading = std::make_unique<ShadingSet>(character->asset);
    return character;
}

static SceneFile openFile(const std::filesystem::path& path, int threads) {
    SceneFile file;
    if (path.extension() != ".exr" && path.extension() != ".hdr") {
        file.asset = std::make_unique<OpenAsset>(path);
        return file;
    }
    const MapProjection projection = projectMap(readEnvironmentMap(path, ""), kPictureLightOrder, threads);
    file.light_name = path.filename();
    file.light_sh.assign(projection.sh.begin(), projection.sh.end());
    return file;
}

// Opens each file once, however often it is named; for every path, which of scene.files it is.
static std::vector<std::size_t> openFiles(std::span<const std::filesystem::path> paths, int threads, Scene& scene) {
    std::vector<std::size_t> file_of_path;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        std::error_code unreadable;  // then it is opened, and the reason said
        std::size_t same = 0;
        while (same < i && !std::filesystem::equivalent(paths[same], paths[i], unreadable)) ++same;
        file_of_path.push_back(same < i ? file_of_path[same] : scene.files.size());
        if (same == i) scene.files.push_back(openFile(paths[i], threads));
    }
    return file_of_path;
}

Scene openScene(std::span<const std::filesystem::path> paths, int threads) {
    Scene scene;
    const std::vector<std::size_t> file_of_path = openFiles(paths, threads, scene);
    std::vector<const Character*> first_of_file(scene.files.size());
    for (const std::size_t index : file_of_path) {
        const SceneFile& file = scene.files[index];
        if (!file.asset || !isCharacter(file.asset->view)) continue;
        scene.characters.push_back(makeCharacter(scene, file, first_of_file[index]));
        if (!first_of_file[index]) first_of_file[index] = scene.characters.back().get();
    }
    if (scene.characters.empty())
        throw InvalidInput(paths.front().string() + ": holds no model; make one with penumbra-pack asset");
    for (const SceneFile& file : scene.files)
        if (file.asset && file.asset->view.has_truth) attachTruth(scene, file.asset->view);
    const AssetView& first = scene.characters.front()->asset;
    for (const MaterialView& material : first.materials) scene.material_names.push_back(material.name);
    for (const LightView& light : first.lights) scene.light_names.push_back(light.name);
    placeCharacters(scene);
    return scene;
}

ViewContents contentsOf(const Scene& scene) {
    ViewContents contents;
    for (const auto& character : scene.characters)
        contents.characters.push_back(
            {&character->asset.animation, std::max<std::size_t>(1, character->asset.mesh.slots.size()),
             mostComponents(character->asset.model), character->truth != nullptr, character->strip.clip(),
             character->strip.outOfRange(), character->error_strip.errors()});
    contents.materials = scene.material_names.size();
    contents.lights = scene.light_names.size();
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
    if (!contents.shaded() && state.channel == Channel::kShaded) state.channel = Channel::kAmbient;
    if (!contents.hasTruth()) state.compare = Compare::kModel;
    state.frame_all = true;
    state.picked.reset();
    state.score_edit.reset();
    if (state.component && *state.component >= contents.components()) state.component.reset();
    return state;
}

static std::string_view nameOf(Compare compare) {
    static constexpr std::string_view kNames[] = {"model", "truth", "side by side", "wipe", "difference"};
    return kNames[std::size_t(compare)];
}

// "3", or "3.42" between two frames
static std::string frameText(const ClipPosition& position) {
    char text[32];
    std::snprintf(text, sizeof text, position.part > 0 ? "%.2f" : "%.0f", double(position.frame) + position.part);
    return text;
}

std::string describe(const Scene& scene, const ViewState& state) {
    const ViewContents contents = contentsOf(scene);
    const ClipView& clip = selectedClip(state, contents);
    std::string text = "clip " + std::string(clip.name) + ", frame " +
                       frameText(shownPosition(state, contents, state.selected)) + ", " +
                       std::string(nameOf(state.channel)) + ", " + std::string(nameOf(shownCompare(state)));
    if (state.channel == Channel::kShaded)
        text += ", material " + std::string(scene.material_names[chosenMaterial(state)]) + ", light " +
                std::string(scene.light_names[state.light]);
    const ShadingChoice shading = shownShading(scene, state);
    if (state.channel == Channel::kShaded && shading != ShadingChoice())
        text += std::string(", reflectance ") + std::string(nameOf(shading.reflectance)) + ", light form " +
                std::string(nameOf(shading.light_form));
    if (state.component) text += ", component " + std::to_string(*state.component);
    if (state.score_edit) text += ", scores of cluster " + std::to_string(state.score_edit->cluster) + " changed";
    return text;
}

// --- One frame -------------------------------------------------------------------------------------------------------

static double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

static Shot shotOf(const Character& character) {
    Shot shot;
    shot.asset = &character.asset;
    shot.frame = character.frame;
    shot.truth = character.truth;
    shot.truth_frame = character.truth_frame.value_or(0);
    return shot;
}

static void editScores(Character& character, const std::optional<ScoreEdit>& edit) {
    character.edited = edit;
    if (!edit) return;
    const std::span<const float> scores = character.evaluator->scores(edit->cluster);
    std::vector<float> sum(scores.begin(), scores.end());
    for (std::size_t k = 0; k < std::min(sum.size(), edit->added.size()); ++k) sum[k] += edit->added[k];
    character.evaluator->setScores(edit->cluster, sum);
}

static void poseCharacter(Character& character, const ClipView& clip, const ClipPosition& position,
                          const std::optional<ScoreEdit>& edit, int threads) {
    const std::size_t frame = clip.first_frame + position.frame;
    if (character.posed && character.frame == frame && character.part == position.part && character.edited == edit)
        return;
    PoseInterpolation& pose = *character.interpolation;
    pose.evaluate(frame, clip.first_frame + position.next, position.part);
    character.evaluator->setPose(pose.bones(), pose.pose());
    editScores(character, edit);
    skinFrame(*character.evaluator, threads, character.vertices);
    character.frame = frame;
    character.part = position.part;
    character.truth_frame.reset();
    if (character.truth && position.part == 0)
        character.truth_frame = findTruthFrame(character.asset, *character.truth, frame);
    character.posed = true;
    character.has_model_numbers = character.has_truth_numbers = false;
}

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
        if (!character->shading || character->shading->choice() == choice) continue;
        character->shading = std::make_unique<ShadingSet>(character->asset, choice);
        changed = true;
    }
    return changed;
}

static void setShading(Character& character, const CharacterChoice& choice, const ViewState& state) {
    if (!character.shading) return;
    ShadingSet& set = *character.shading;
    for (std::size_t slot = 0; slot < set.slotCount(); ++slot)
        if (set.materialOfSlot()[slot] != choice.material_of_slot[slot])
            set.setMaterial(slot, choice.material_of_slot[slot]);
    if (set.light() != state.light) set.setLight(state.light);
    const Mat3 rotation = lightRotation(state);
    if (set.lightRotation() != rotation) set.setLightRotation(rotation);
}

static void needNumbers(Character& character, bool model, bool truth, int threads) {
    if (model && !character.has_model_numbers) {
        evaluateNumbers(*character.evaluator, threads, character.vertices);
        character.has_model_numbers = true;
    }
    if (truth && character.truth_frame && !character.has_truth_numbers) {
        character.truth_numbers = truthNumbers(shotOf(character), character.vertices, threads);
        character.has_truth_numbers = true;
    }
}

static std::vector<Vec3> valuesOf(Character& character, bool truth, Channel channel, Vec3 eye, int threads) {
    std::vector<float> true_ambient;
    if (channel == Channel::kError) true_ambient = ambientOf(shotOf(character), character.truth_numbers, threads);
    // The same local frames, other numbers.
    if (truth) std::swap(character.vertices.numbers, character.truth_numbers);
    std::vector<Vec3> values = channelValues(shotOf(character), channel, character.shading.get(), character.vertices,
                                             true_ambient, eye, threads);
    if (truth) std::swap(character.vertices.numbers, character.truth_numbers);
    return values;
}

static void noteError(Character& character) {
    character.mean_error = character.max_error = 0;
    const std::vector<Vec3>& values = character.values[std::size_t(Shown::kModel)];
    for (const Vec3& value : values) {
        character.mean_error += double(value.x) / double(values.size());
        character.max_error = std::max(character.max_error, double(value.x));
    }
}

// A frame without truth shows its model wherever truth is asked for.
static void showValues(Character& character, Compare compare, Vec3 eye, int threads) {
    const bool has_truth = character.truth_frame.has_value();
    auto& [model, truth, difference] = character.values;
    if (compare != Compare::kTruth || !has_truth) model = valuesOf(character, false, character.channel, eye, threads);
    if (compare != Compare::kModel)
        truth = has_truth ? valuesOf(character, true, character.channel, eye, threads) : model;
    if (character.channel == Channel::kError) noteError(character);
    if (compare != Compare::kDifference) return;
    difference.resize(model.size());
    for (std::size_t v = 0; v < model.size(); ++v)
        for (int c = 0; c < 3; ++c) difference[v][c] = std::abs(model[v][c] - truth[v][c]);
}

// The component's effect on E as colours, in the place of what the channel shows.
static void showComponent(Character& character, std::size_t component) {
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

void updateScene(Scene& scene, const ViewState& state, const UpdateNeeds& needs, UpdateCost& cost) {
    const ViewContents contents = contentsOf(scene);
    const Vec3 eye = toFloat(cameraPosition(state.camera));
    cost = {};
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        Character& character = *scene.characters[i];
        auto start = std::chrono::steady_clock::now();
        const ClipView& clip = character.asset.animation.clips[state.characters[i].clip];
        const bool is_edited = state.score_edit && state.score_edit->character == i;
        poseCharacter(character, clip, shownPosition(state, contents, i), is_edited ? state.score_edit : std::nullopt,
                      needs.threads);
        const Compare compare = shownCompare(state);
        const bool picked = state.picked && state.picked->character == i;
        const bool truth = compare != Compare::kModel || state.channel == Channel::kError || picked;
        const bool model = compare != Compare::kTruth || !character.truth_frame;
        character.channel =
            state.channel == Channel::kError && !character.truth_frame ? Channel::kAmbient : state.channel;
        needNumbers(character, (needs.values && model) || picked, truth, needs.threads);
        cost.evaluate += millisecondsSince(start);
        start = std::chrono::steady_clock::now();
        setShading(character, state.characters[i], state);
        character.plain = state.component.has_value();
        if (state.component)
            showComponent(character, *state.component);
        else if (needs.values)
            showValues(character, compare, eye - character.offset, needs.threads);
        cost.shade += millisecondsSince(start);
    }
}

static void computeComponents(Character& character, std::size_t vertex, double milliseconds) {
    character.score_ranges.compute(*character.strip_evaluator, milliseconds);
    const std::size_t cluster = clusterAt(character.asset.model, vertex);
    if (character.components_of == cluster || !character.score_ranges.complete()) return;
    character.components = character.score_ranges.figures(*character.strip_evaluator, cluster);
    character.components_of = cluster;
}

void computeStrips(Scene& scene, const ViewState& state, double milliseconds) {
    Character& character = *scene.characters[state.selected];
    const std::size_t clip = state.characters[state.selected].clip;
    const auto start = std::chrono::steady_clock::now();
    character.strip.compute(*character.strip_evaluator, clip, milliseconds);
    const double left = milliseconds - millisecondsSince(start);
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

static BoundingBox boundsOf(const Scene& scene, bool rest) {
    BoundingBox all;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const Character& character = *scene.characters[i];
        const bool posed = character.posed && !rest;
        BoundingBox box =
            boundsOf(posed ? std::span<const Vec3>(character.vertices.positions) : character.asset.mesh.positions);
        box.low += character.offset;
        box.high += character.offset;
        all = i == 0 ? box : joined(all, box);
    }
    return all;
}

BoundingBox boundsOf(const Scene& scene) { return boundsOf(scene, false); }
BoundingBox restBounds(const Scene& scene) { return boundsOf(scene, true); }

}  // namespace penumbra
