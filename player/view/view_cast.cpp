#include "player/view/view_cast.h"

#include <algorithm>
#include <stdexcept>

#include "formats/common/errors.h"
#include "player/scene/posed_scene.h"
#include "player/scene/scene_receivers.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_look.h"

namespace penumbra {

void makeCasters(Scene& scene) {
    std::vector<const Evaluator*> casters;
    std::vector<CasterKind> kinds;
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        Character& character = *scene.characters[i];
        const SceneCharacter* member = memberOf(scene, i);
        const std::optional<CasterKind> kind =
            member ? casterKindOf(*member, *character.posed.evaluator) : casterKindOf(*character.posed.evaluator);
        if (!kind) continue;
        character.casts = kind;
        character.caster = casters.size();
        casters.push_back(character.posed.evaluator.get());
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

void takeOver(Scene& scene, Character& character) {
    const CharacterPose& posed = character.posed;
    FrameVertices& at = character.posed.in_scene;
    const Mat3 turn = posed.to_scene.linear();
    at.positions = posed.vertices.positions;
    at.normals = posed.vertices.normals;
    at.tangents = posed.vertices.tangents;
    for (Vec3& p : at.positions) p = posed.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&at.normals, &at.tangents})
        for (Vec3& d : *directions) d = turn * d;
    if (character.caster == kNobody) return;
    for (CastShadow* cast : {scene.cast.get(), scene.sphere_cast.get()})
        if (cast) cast->pose(character.caster, character.posed.evaluator->bones(), character.posed.to_scene);
}

namespace {

CastReceivers receiversOf(const FrameVertices& at) { return {at.positions, at.normals, at.tangents}; }

}  // namespace

void applyShadows(const Scene& scene, std::size_t index, const CoefficientsKey& key, int threads,
                  CastCoefficients coefficients, HiddenSky* hidden) {
    const Shadows shadows = key.shadows;
    const Character& character = *scene.characters[index];
    const ModelView& model = character.asset.model;
    if (!changesCoefficients(scene, index, key)) return;
    if (shadows == Shadows::kCast || shadows == Shadows::kNone) {
        const std::vector<float> open = freeSight(model.convention);
        for (std::size_t first = 0; first < coefficients.coefficients.size(); first += std::size_t(model.stride))
            std::ranges::copy(open, coefficients.coefficients.begin() + std::ptrdiff_t(first));
    }
    if (shadows == Shadows::kNone) return;
    CoefficientsKey others = key;
    others.shadows = Shadows::kBoth;
    if (!changesCoefficients(scene, index, others)) return;
    castOthers({*scene.cast, {.except = character.caster}, scene.field.get(), key.on_ground},
               *character.posed.evaluator, receiversOf(character.posed.in_scene), threads, coefficients, hidden);
}

void poseField(Scene& scene, const ViewState& state) {
    if (scene.field && scene.field->heights().moves())
        scene.field->pose(scene.ground_file->heights->seconds + state.playhead.time);
}

namespace {

// E in x.
std::vector<Vec3> ambientValues(const GroundVertices& ground) {
    std::vector<Vec3> values;
    for (const float e : groundAmbient(ground)) values.push_back({e, 0, 0});
    return values;
}

// Computes the points of a ground with heights, unless they are there, and what they show.
void showField(Scene& scene, const ViewState& state, const GroundKey& key, const LightView* light, int threads,
               std::vector<Vec3>& values) {
    ShownGround& ground = scene.ground;
    const bool anew = ground.seen.update({key.seen, key.on_cpu}), moved = ground.heights.update(key.field);
    if (anew || moved) {
        const CastShadow nobody({});
        const CastShadow& cast = key.seen.shadows == Shadows::kCast ? *scene.cast : nobody;
        ground.updated =
            scene.field->update(cast, anew ? FieldPoints::kNew : FieldPoints::kKept, threads, ground.points);
        ground.vertices.positions = ground.points.positions;
        ground.vertices.normals = ground.points.normals;
        ground.vertices.tangents = ground.points.tangents;
        if (ground.vertices.triangles.empty())
            ground.vertices.triangles = fieldTriangles(scene.field->heights().field().grid());
    }
    values.clear();
    if (!light) {
        for (const float e : fieldAmbient(scene.field->convention(), ground.points)) values.push_back({e, 0, 0});
        return;
    }
    FieldLook look(*scene.ground_file, scene.field->convention(), scene.characters.front()->asset, *light);
    look.turnLight(lightRotation(state));
    look.shade(ground.points, toFloat(cameraPosition(state.camera)), threads, values);
}

const CastShadow& castersOf(const Scene& scene, CastMode mode) {
    return needsSpheres(mode) ? *scene.sphere_cast : *scene.cast;
}

void showLevelGround(Scene& scene, const ViewState& state, const GroundKey& key, const LightView* light, int threads,
                     std::vector<Vec3>& values) {
    const bool joins = key.seen.mode != CastMode::kProduct;
    ShownGround& ground = scene.ground;
    const SceneGround& file = *scene.ground_file;
    const Mat3d rotation = toDouble(lightRotation(state));
    if (ground.seen.update({key.seen, key.on_cpu})) {
        const CastShadow nobody({});
        if (joins || ground.vertices.positions.empty()) ground.vertices = groundMesh(file);
        if (!joins) castOnGround(key.seen.shadows == Shadows::kCast ? *scene.cast : nobody, threads, ground.vertices);
    }
    if (!joins) {
        values = light ? groundRadiance(ground.vertices, *light, rotation, file.albedo, threads)
                       : ambientValues(ground.vertices);
        if (light && key.received > 0)
            addMembersLight(ground.vertices, scene.received.shining, file.albedo, threads, values);
        return;
    }
    values = joinedGround(key.seen.mode, castersOf(scene, key.seen.mode),
                          {ground.vertices.positions, ground.vertices.normals, ground.vertices.tangents}, light,
                          rotation, file.albedo, threads);
}

}  // namespace

bool updateGround(Scene& scene, const ViewState& state, const GroundKey& key, int threads) {
    if (!state.show.ground || !scene.ground_file) return false;
    return scene.ground.values.update(key, [&](std::vector<Vec3>& values) {
        if (scene.field && !key.on_cpu) return;
        LightView light;
        if (key.lit) light = shownLight(scene, state);
        const std::vector<float> remainder = key.suns ? remainderOf(light) : std::vector<float>();
        if (key.suns) light.sh = remainder;
        (scene.field ? showField : showLevelGround)(scene, state, key, key.lit ? &light : nullptr, threads, values);
        if (key.lit) return;
        for (Vec3& value : values) value = scene.ground_file->albedo * (0.5f * value.x);
    });
}

std::vector<Vec3> joinedValues(Scene& scene, std::size_t index, const ViewState& state, const CharacterKey& key,
                               bool truth, int threads) {
    Character& character = *scene.characters[index];
    CharacterLook& shown = character.shown;
    FrameVertices own = character.posed.in_scene;
    own.coefficients = character.posed.vertices.coefficients;
    own.indirect = character.posed.vertices.indirect;
    shown.joined.update(key.coefficients, [&](JoinedCast& joined) {
        joined.see(key.coefficients.mode, castersOf(scene, key.coefficients.mode), {.except = character.caster}, own,
                   threads);
    });
    const auto ambient = [&] { return shown.joined->ambient(character.asset.model, own); };
    if (key.channel == Channel::kError) {
        std::vector<Vec3> values = ambient();
        own.coefficients = *character.posed.truth_coefficients;
        const std::vector<Vec3> baked = ambient();
        for (std::size_t v = 0; v < values.size(); ++v) values[v].x = std::abs(values[v].x - baked[v].x);
        return values;
    }
    if (truth) own.coefficients = *character.posed.truth_coefficients;
    if (key.channel != Channel::kShaded) return ambient();
    shown.joined_look.update(key.look, [&](auto&) {
        Shot shot;
        shot.asset = &character.asset;
        shot.shaded = true;
        shot.shading = key.look.shading;
        shot.material_of_slot = key.look.material_of_slot;
        shot.light = key.look.light.light;
        shot.light_rotation = lightRotation(state);
        setParameters(scene, state, shown.joined->dress(shot));
    });
    return shown.joined->radiance(own, key.eye, threads);
}

}  // namespace penumbra
