#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "player/frame/lobe_table.h"
#include "player/frame/shot.h"
#include "player/papers/cast_shader.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// How a member of a scene looks. It stays where it is, because the shot points to the view.
struct SceneLook {
    AssetView view;  // the member's asset with the light of the scene
    bool drawn;      // real props are not
    Shot shot;
    // One of these for Channel::kShaded: the second for modes that compare (PosedScene::castWay()).
    std::optional<ShadingSet> shading;
    std::optional<CastShader> cast_shader;
    std::vector<LobeRange> lobes;       // of every vertex, where suns shine
    std::vector<SlotLobes> slot_lobes;  // and of every slot

    // Of the options it reads channel and shading. Throws BadOption for a member without materials.
    SceneLook(const PosedScene& scene, const SceneMember& member, const RenderOptions& options);
    SceneLook(const SceneLook&) = delete;
};

// What suns need of a scene beside its vertices.
struct SceneSunlight {
    LobeTable lobes;               // of all materials
    std::vector<Sun> suns;         // in the scene; empty: all light is SH
    std::vector<float> remainder;  // SH of the light without its suns
    LobeRange ground = 0;          // lobes of the ground, where there is a level one
    Mat3 light_rotation;
    LightView light;  // what vertices are shaded with: that of the scene, or its remainder
};
// Suns shine on everyone or on nobody, so that all have the same light. Sets the lobes of the looks.
SceneSunlight sceneSunlight(const PosedScene& scene, std::span<const std::unique_ptr<SceneLook>> looks);

// Throws BadOption where a scene without a light is to be shaded.
void requireLight(const PosedScene& scene, Channel channel);

}  // namespace penumbra
