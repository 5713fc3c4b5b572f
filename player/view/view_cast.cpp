#include "player/view/view_cast.h"

#include <algorithm>
#include <stdexcept>

#include "formats/common/errors.h"
#include "player/scene/posed_scene.h"
#include "player/scene/scene_receivers.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_light.h"
#include "player/view/view_shapes.h"
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
    } catch (const std::length_error& error) {
        throw Unsupported(error.what());
    }
}

void takeOver(Scene& scene, std::size_t index) {
    Character& character = *scene.characters[index];
    if (character.caster == kNobody) return;
    scene.cast->pose(character.caster, character.evaluator->bones(), character.to_scene);
    ++scene.cast_version;
}

namespace {

bool hasOthers(const Scene& scene, std::size_t index) {
    return scene.cast->casterCount() > (scene.characters[index]->caster == kNobody ? 0u : 1u);
}

}  // namespace

bool changesNumbers(const Scene& scene, std::size_t index, Shadows shadows) {
    if (shadows == Shadows::kSelf) return false;
    return shadows != Shadows::kBoth || hasOthers(scene, index);
}

void applyShadows(const Scene& scene, std::size_t index, Shadows shadows, int threads, std::span<float> numbers) {
    const Character& character = *scene.characters[index];
    const ModelView& model = character.asset.model;
    if (shadows == Shadows::kCast || shadows == Shadows::kNone) {
        const std::vector<float> open = freeSight(model.convention);
        for (std::size_t first = 0; first < numbers.size(); first += std::size_t(model.stride))
            std::ranges::copy(open, numbers.begin() + std::ptrdiff_t(first));
    }
    if (shadows == Shadows::kSelf || shadows == Shadows::kNone || !hasOthers(scene, index)) return;
    const FrameVertices& at = character.vertices;
    std::vector<Vec3> positions, normals, tangents;
    const Mat3 turn = character.to_scene.linear();
    for (const Vec3 p : at.positions) positions.push_back(character.to_scene.point(p));
    for (const Vec3 n : at.normals) normals.push_back(turn * n);
    for (const Vec3 t : at.tangents) tangents.push_back(turn * t);
    castOnNumbers(*scene.cast, {.except = character.caster}, {positions, normals, tangents}, model, threads, numbers);
}

SceneGround groundUnder(const BoundingBox& box) {
    constexpr double kRadii = 8;  // of the box, a side
    SceneGround ground;
    ground.centre = (box.low + box.high) * 0.5f;
    ground.height = double(box.low.y);
    ground.size = std::max(kRadii * box.radius(), 1e-3);
    ground.resolution = 6 * kGroundTiles + 1;
    ground.albedo = {0.25f, 0.25f, 0.25f};
    return ground;
}

void updateGround(Scene& scene, const ViewState& state, int threads) {
    if (!state.ground || !scene.ground_file) return;
    ShownGround& ground = scene.ground;
    const bool shadows = state.shadows == Shadows::kBoth || state.shadows == Shadows::kCast;
    const ShadingSet* shading = scene.characters.front()->shading.get();
    const bool lit = shading && state.channel == Channel::kShaded && !state.component;
    const bool suns = showsSuns(scene, state);
    const ShownGround::Made made{shadows,
                                 lit,
                                 suns,
                                 scene.cast_version,
                                 lit ? shownLightKey(scene, state) : LightKey(),
                                 lit ? lightRotation(state) : Mat3()};
    if (ground.made == made) return;
    if (!ground.made || ground.made->shadows != shadows || ground.made->cast_version != scene.cast_version) {
        const CastShadow nobody({});
        const CastShadow& cast = shadows ? *scene.cast : nobody;
        ground.vertices = groundVertices(*scene.ground_file, cast, threads);
    }
    ground.made = made;
    ++ground.version;
    const Vec3 albedo = scene.ground_file->albedo;
    if (lit) {
        LightView light = shownLight(scene, state);
        const std::vector<float> remainder = suns ? remainderOf(light) : std::vector<float>();
        if (suns) light.sh = remainder;
        ground.values = groundRadiance(ground.vertices, light, toDouble(lightRotation(state)), albedo);
        return;
    }
    ground.values.clear();
    for (const float e : groundAmbient(ground.vertices)) ground.values.push_back(albedo * (0.5f * e));
}

}  // namespace penumbra
