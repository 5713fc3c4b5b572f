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
    std::vector<LobeRange> lobes;       // one for each vertex that suns can reach
    std::vector<SlotLobes> slot_lobes;  // one for each slot

    // Reads from the options: channel and shading. Throws BadOption for a member without materials.
    SceneLook(const PosedScene& scene, const SceneMember& member, const RenderOptions& options);
    SceneLook(const SceneLook&) = delete;
};

// Inputs of suns besides the vertices of the scene.
struct SceneSunlight {
    LobeTable lobes;               // lobes of all materials
    std::vector<Sun> suns;         // in the scene; empty: all light is SH
    std::vector<float> remainder;  // SH of the light without its suns
    LobeRange ground = 0;          // lobes of the ground, where there is a level one
    Mat3 light_rotation;
    LightView light;  // the light that shades vertices: the scene's, or its remainder without suns
};
// Suns shine on everyone or on nobody, so that all have the same light. Sets the lobes of the looks.
SceneSunlight sceneSunlight(const PosedScene& scene, std::span<const std::unique_ptr<SceneLook>> looks);

// Throws BadOption where a scene without a light is to be shaded.
void requireLight(const PosedScene& scene, Channel channel);

}  // namespace penumbra
