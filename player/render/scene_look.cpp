#include "player/render/scene_look.h"

#include "formats/common/errors.h"

namespace penumbra {

namespace {

AssetView litView(const PosedScene& scene, const SceneMember& member) {
    AssetView view = member.asset->view;
    view.lights = scene.lightAsset().lights;
    return view;
}

Shot lookOf(const PosedScene& scene, const SceneMember& member, const RenderOptions& options, const AssetView& view) {
    RenderOptions look;
    look.channel = options.channel == Channel::kError ? Channel::kAmbient : options.channel;
    look.shading = options.shading;
    look.bounces = options.bounces;
    look.suns = scene.castWay().mode == CastMode::kProduct ? options.suns : SunChoice::kOff;
    look.brdf = member.file->material;
    for (const auto& [slot, material] : member.file->slots) look.slots.push_back(slot + "=" + material);
    look.light = scene.file().light.name;
    look.light_rotation = scene.file().light.rotation;
    try {
        return resolveLook(look, view, nullptr);
    } catch (const UsageError& error) {
        throw UsageError(member.file->at + ": " + error.what());
    }
}

}  // namespace

SceneLook::SceneLook(const PosedScene& scene, const SceneMember& member, const RenderOptions& options)
    : view(litView(scene, member)), shot(lookOf(scene, member, options, view)) {
    if (!shot.shaded) return;
    if (scene.castWay().mode == CastMode::kProduct)
        shading.emplace(shadingOf(shot));
    else
        cast_shader.emplace(scene.castWay().mode, shot);
}

void requireLight(const PosedScene& scene, Channel channel) {
    if (channel == Channel::kShaded && !scene.light())
        throw UsageError("the scene has no light: name an asset that has one under \"light\", or ask for --channel ao");
}

}  // namespace penumbra
