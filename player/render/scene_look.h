#pragma once
#include <optional>
#include <vector>

#include "player/frame/lobe_table.h"
#include "player/frame/shot.h"
#include "player/scene/cast_shader.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// How a member of a scene looks. It stays where it is, because the shot points to the view.
struct SceneLook {
    AssetView view;  // the member's asset with the light of the scene
    Shot shot;
    // One of these for Channel::kShaded: the second for modes that compare (PosedScene::castWay()).
    std::optional<ShadingSet> shading;
    std::optional<CastShader> cast_shader;
    std::vector<LobeRange> lobes;  // of every vertex, where suns shine

    // Of the options it reads channel and shading. Throws UsageError for a member without materials.
    SceneLook(const PosedScene& scene, const SceneMember& member, const RenderOptions& options);
    SceneLook(const SceneLook&) = delete;
};

// Throws UsageError where a scene without a light is to be shaded.
void requireLight(const PosedScene& scene, Channel channel);

}  // namespace penumbra
