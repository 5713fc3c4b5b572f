#include "player/render/scene_look.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "player/scene/scene_suns.h"

namespace penumbra {

namespace {

AssetView litView(const PosedScene& scene, const SceneMember& member) {
    AssetView view = member.asset->view;
    view.lights = scene.lightAsset().lights;
    return view;
}

Shot lookOf(const PosedScene& scene, const SceneMember& member, const RenderOptions& options, const AssetView& view) {
    RenderOptions look;
    const bool plain = options.channel == Channel::kError || member.file->real;
    look.channel = plain ? Channel::kAmbient : options.channel;
    look.shading = options.shading;
    if (options.suns == SunChoice::kOn && scene.castWay().mode != CastMode::kProduct)
        throw BadOption("suns", "needs shadows of others that join as a product");
    look.bounces = options.bounces;
    look.textures = options.textures;
    look.suns = scene.castWay().mode == CastMode::kProduct ? options.suns : SunChoice::kOff;
    look.brdf = member.file->material;
    for (const auto& [slot, material] : member.file->slots) look.slots.push_back(slot + "=" + material);
    look.light = scene.file().light.name;
    look.light_rotation = scene.file().light.rotation;
    try {
        return resolveLook(look, view, nullptr);
    } catch (const UsageError& error) {
        throw BadOption(member.file->at, error.what());
    }
}

}  // namespace

SceneLook::SceneLook(const PosedScene& scene, const SceneMember& member, const RenderOptions& options)
    : view(litView(scene, member)), drawn(!member.file->real), shot(lookOf(scene, member, options, view)) {
    if (!shot.shaded) return;
    if (scene.castWay().mode == CastMode::kProduct)
        shading.emplace(shadingOf(shot));
    else
        cast_shader.emplace(scene.castWay().mode, shot);
}

SceneSunlight sceneSunlight(const PosedScene& scene, std::span<const std::unique_ptr<SceneLook>> looks) {
    SceneSunlight out;
    if (scene.light()) out.light = *scene.light();
    const auto first = std::ranges::find_if(looks, [](const auto& look) { return look->drawn; });
    if (first == looks.end()) return out;
    out.light_rotation = (*first)->shot.light_rotation;
    if (!std::ranges::all_of(looks, [](const auto& look) { return look->shot.suns || !look->drawn; })) return out;
    for (const std::unique_ptr<SceneLook>& look : looks) {
        if (!look->drawn) continue;
        look->lobes = out.lobes.add(*look->shading);
        look->slot_lobes = out.lobes.addSlots(*look->shading);
    }
    out.suns = sunsOf(*scene.light(), out.light_rotation);
    out.remainder = remainderOf(*scene.light());
    out.light.sh = out.remainder;
    if (!scene.file().ground || scene.field()) return out;
    const BrdfLobe paint{BrdfModel::kLambert, {}, scene.file().ground->albedo};
    out.ground = out.lobes.add({&paint, 1});
    return out;
}

void requireLight(const PosedScene& scene, Channel channel) {
    if (channel == Channel::kShaded && !scene.light())
        throw BadOption("channel", "the scene has no light: name an asset that has one under \"light\", or ask for ao");
}

}  // namespace penumbra
