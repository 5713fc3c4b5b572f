#include "player/view/view_cast_way.h"

#include <cmath>

#include "player/scene/sphere_cast.h"
#include "player/view/view_material.h"

namespace penumbra {

CastMode shownCastMode(const ViewState& state) {
    const bool cast = state.shadows == Shadows::kBoth || state.shadows == Shadows::kCast;
    const bool joins =
        state.channel == Channel::kShaded || state.channel == Channel::kAmbient || state.channel == Channel::kError;
    return cast && joins && !state.component ? state.cast_mode : CastMode::kProduct;
}

bool hasCastMode(const ViewContents& contents, CastMode mode) {
    if (mode == CastMode::kProduct || contents.heights) return mode == CastMode::kProduct;
    return (needsSpheres(mode) ? contents.sphere_casters : contents.casters) > 0;
}

void chooseNextCastMode(ViewState& state, const ViewContents& contents, bool back) {
    do {
        state.cast_mode = CastMode((std::size_t(state.cast_mode) + (back ? kCastModes - 1 : 1)) % kCastModes);
    } while (!hasCastMode(contents, state.cast_mode));
}

Shadows shadowsOfNumbers(Shadows shadows, CastMode mode) {
    if (mode == CastMode::kProduct) return shadows;
    return shadows == Shadows::kBoth ? Shadows::kSelf : Shadows::kNone;
}

namespace {

const CastShadow& castersOf(const Scene& scene, CastMode mode) {
    return needsSpheres(mode) ? *scene.sphere_cast : *scene.cast;
}

// The vertices of a character where it stands.
FrameVertices inScene(const Character& character) {
    const Mat3 turn = character.to_scene.linear();
    FrameVertices out = character.vertices;
    for (Vec3& p : out.positions) p = character.to_scene.point(p);
    for (std::vector<Vec3>* directions : {&out.normals, &out.tangents})
        for (Vec3& d : *directions) d = turn * d;
    return out;
}

CastShader& shaderOf(Character& character, const CharacterChoice& choice, const JoinedLook& look) {
    if (character.joined && character.joined_look == look) return *character.joined;
    Shot shot;
    shot.asset = &character.asset;
    shot.shaded = true;
    shot.shading = look.shading;
    shot.material_of_slot = choice.material_of_slot;
    shot.light = look.light;
    shot.light_rotation = look.light_rotation;
    character.joined = std::make_unique<CastShader>(look.mode, shot);
    character.joined_look = look;
    return *character.joined;
}

}  // namespace

void needOthers(Scene& scene, std::size_t index, CastMode mode, int threads) {
    Character& character = *scene.characters[index];
    if (character.others_mode == mode && character.others_version == scene.pose_version) return;
    const FrameVertices at = inScene(character);
    castOverSphere(castersOf(scene, mode), {.except = character.caster}, castOrderOf(mode),
                   {at.positions, at.normals, at.tangents}, threads, character.others);
    character.others_mode = mode;
    character.others_version = scene.pose_version;
}

std::vector<Vec3> joinedValues(Scene& scene, std::size_t index, const ViewState& state, bool truth, int threads) {
    Character& character = *scene.characters[index];
    const CastMode mode = shownCastMode(state);
    FrameVertices own = inScene(character);
    std::vector<Vec3> values;
    if (character.channel == Channel::kShaded) {
        if (truth) own.numbers = character.truth_numbers;
        const CharacterChoice& choice = state.characters[index];
        const JoinedLook look{mode, choice.material_of_slot, state.light, lightRotation(state),
                              shownShading(scene, state)};
        CastShader& shader = shaderOf(character, choice, look);
        setParameters(scene, state, shader.shading());
        shader.shade(own, character.others, toFloat(cameraPosition(state.camera)), threads, values);
        return values;
    }
    const ModelView& model = character.asset.model;
    const auto ambient = [&] { return castAmbient(mode, model, own, character.others); };
    const bool error = character.channel == Channel::kError;
    const std::vector<float> modelled = truth && !error ? std::vector<float>() : ambient();
    own.numbers = character.truth_numbers;
    const std::vector<float> baked = truth || error ? ambient() : std::vector<float>();
    for (const float e : truth ? baked : modelled) values.push_back({e, 0, 0});
    if (error)
        for (std::size_t v = 0; v < values.size(); ++v) values[v].x = std::abs(modelled[v] - baked[v]);
    return values;
}

std::vector<Vec3> joinedGround(const Scene& scene, const GroundVertices& ground, CastMode mode, const LightView* light,
                               const Mat3& light_rotation, int threads) {
    std::vector<float> cast;
    castOverSphere(castersOf(scene, mode), {}, castOrderOf(mode), {ground.positions, ground.normals, ground.tangents},
                   threads, cast);
    return groundInMode(mode, cast, light, toDouble(light_rotation), scene.ground_file->albedo);
}

}  // namespace penumbra
