#include "player/view/view_cast.h"

#include <algorithm>
#include <stdexcept>

#include "formats/common/errors.h"
#include "player/scene/posed_scene.h"
#include "player/scene/scene_receivers.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_cast_way.h"
#include "player/view/view_light.h"
#include "player/view/view_suns.h"

namespace penumbra {

void makeCasters(Scene& scene) {
    std::vector<const Evaluator*> casters;
    std::vector<CasterKind> kinds;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        Character& character = *scene.characters[i];
        const SceneCharacter* member = memberOf(scene, i);
        const std::optional<CasterKind> kind =
            member ? casterKindOf(*member, *character.evaluator) : casterKindOf(*character.evaluator);
        if (!kind) continue;
        character.casts = kind;
        character.caster = casters.size();
        casters.push_back(character.evaluator.get());
        kinds.push_back(*kind);
    }
    try {
        scene.cast = std::make_unique<CastShadow>(casters, kinds);
        std::ranges::fill(kinds, CasterKind::kSpheres);
        if (std::ranges::none_of(casters, [](const Evaluator* e) { return e->asset().blockers.spheres.empty(); }))
            scene.sphere_cast = std::make_unique<CastShadow>(casters, kinds);
    } catch (const std::length_error& error) {
        throw Unsupported(error.what());
    }
}

void takeOver(Scene& scene, std::size_t index) {
    Character& character = *scene.characters[index];
    if (character.caster == kNobody) return;
    for (CastShadow* cast : {scene.cast.get(), scene.sphere_cast.get()})
        if (cast) cast->pose(character.caster, character.evaluator->bones(), character.to_scene);
    ++scene.cast_version;
    ++scene.caster_version;
}

namespace {

bool hasOthers(const Scene& scene, std::size_t index) {
    return scene.cast->casterCount() > (scene.characters[index]->caster == kNobody ? 0u : 1u);
}

}  // namespace

bool changesNumbers(const Scene& scene, std::size_t index, Shadows shadows) {
    // Transfer is no visibility that others could take from.
    if (shadows == Shadows::kSelf || scene.characters[index]->asset.transfer) return false;
    return shadows != Shadows::kBoth || scene.field || hasOthers(scene, index);
}

void applyShadows(const Scene& scene, std::size_t index, Shadows shadows, int threads, std::span<float> numbers,
                  std::span<float> indirect) {
    const Character& character = *scene.characters[index];
    const ModelView& model = character.asset.model;
    if (character.asset.transfer) return;
    if (shadows == Shadows::kCast || shadows == Shadows::kNone) {
        const std::vector<float> open = freeSight(model.convention);
        for (std::size_t first = 0; first < numbers.size(); first += std::size_t(model.stride))
            std::ranges::copy(open, numbers.begin() + std::ptrdiff_t(first));
    }
    if (shadows == Shadows::kSelf || shadows == Shadows::kNone) return;
    if (!hasOthers(scene, index) && !scene.field) return;
    const FrameVertices& at = character.vertices;
    std::vector<Vec3> positions, normals, tangents;
    const Mat3 turn = character.to_scene.linear();
    for (const Vec3 p : at.positions) positions.push_back(character.to_scene.point(p));
    for (const Vec3 n : at.normals) normals.push_back(turn * n);
    for (const Vec3 t : at.tangents) tangents.push_back(turn * t);
    const CastReceivers receivers{positions, normals, tangents};
    castOnNumbers(*scene.cast, {.except = character.caster}, *character.evaluator, receivers, threads, numbers,
                  indirect);
    if (scene.field) scene.field->shadow(receivers, model, threads, numbers, indirect);
}

void poseField(Scene& scene, const ViewState& state) {
    if (!scene.field) return;
    if (scene.field->heights().moves()) scene.field->pose(scene.ground_file->heights->seconds + state.playhead.time);
    if (scene.field->version() == scene.field_version) return;
    scene.field_version = scene.field->version();
    ++scene.cast_version;  // everyone sees another one
    ++scene.pose_version;
}

namespace {

// E in x.
std::vector<Vec3> ambientValues(const GroundVertices& ground) {
    std::vector<Vec3> values;
    for (const float e : groundAmbient(ground)) values.push_back({e, 0, 0});
    return values;
}

// Computes the points of a ground with heights, unless they are there, and what they show.
void showField(Scene& scene, const ViewState& state, bool cast_anew, bool moved, bool shadows, const LightView* light,
               int threads) {
    ShownGround& ground = scene.ground;
    if (cast_anew || moved) {
        const CastShadow nobody({});
        ground.updated = scene.field->update(shadows ? *scene.cast : nobody, cast_anew, threads, ground.points);
        ground.vertices.positions = ground.points.positions;
        ground.vertices.normals = ground.points.normals;
        ground.vertices.tangents = ground.points.tangents;
        if (ground.vertices.triangles.empty())
            ground.vertices.triangles = fieldTriangles(scene.field->heights().field().grid());
    }
    ground.values.clear();
    if (!light) {
        for (const float e : fieldAmbient(scene.field->convention(), ground.points)) ground.values.push_back({e, 0, 0});
        return;
    }
    FieldLook look(*scene.ground_file, scene.field->convention(), scene.characters.front()->asset, *light);
    look.turnLight(lightRotation(state));
    look.shade(ground.points, toFloat(cameraPosition(state.camera)), threads, ground.values);
}

}  // namespace

void updateGround(Scene& scene, const ViewState& state, bool field_on_cpu, int threads) {
    if (!state.ground || !scene.ground_file) return;
    ShownGround& ground = scene.ground;
    const bool shadows = state.shadows == Shadows::kBoth || state.shadows == Shadows::kCast;
    const ShadingSet* shading = scene.characters.front()->shading.get();
    const bool lit = shading && state.channel == Channel::kShaded && !state.component;
    const bool suns = showsSuns(scene, state);
    const CastMode mode = shownCastMode(state);
    const ShownGround::Made made{shadows,
                                 lit,
                                 suns,
                                 field_on_cpu,
                                 mode,
                                 scene.caster_version,
                                 scene.field ? scene.field->version() : 0,
                                 lit ? shownLightKey(scene, state) : LightKey(),
                                 lit ? lightRotation(state) : Mat3(),
                                 scene.ground_file->material.empty() ? Vec3() : toFloat(cameraPosition(state.camera))};
    if (ground.made == made) return;
    const bool cast_anew = !ground.made || ground.made->shadows != shadows || ground.made->mode != mode ||
                           ground.made->caster_version != scene.caster_version || ground.made->on_cpu != field_on_cpu;
    const bool moved = ground.made && ground.made->field_version != made.field_version;
    ground.made = made;
    ++ground.version;
    LightView light;
    if (lit) light = shownLight(scene, state);
    if (scene.field && !field_on_cpu) return;
    if (scene.field) {
        const std::vector<float> remainder = suns ? remainderOf(light) : std::vector<float>();
        if (suns) light.sh = remainder;
        showField(scene, state, cast_anew, moved, shadows, lit ? &light : nullptr, threads);
    } else if (mode != CastMode::kProduct) {
        if (cast_anew) ground.vertices = groundMesh(*scene.ground_file);
        ground.values =
            joinedGround(scene, ground.vertices, mode, lit ? &light : nullptr, lightRotation(state), threads);
    } else {
        const CastShadow nobody({});
        if (cast_anew) ground.vertices = groundVertices(*scene.ground_file, shadows ? *scene.cast : nobody, threads);
        const std::vector<float> remainder = suns ? remainderOf(light) : std::vector<float>();
        if (suns) light.sh = remainder;
        ground.values =
            lit ? groundRadiance(ground.vertices, light, toDouble(lightRotation(state)), scene.ground_file->albedo)
                : ambientValues(ground.vertices);
    }
    if (lit) return;
    for (Vec3& value : ground.values) value = scene.ground_file->albedo * (0.5f * value.x);
}

}  // namespace penumbra
