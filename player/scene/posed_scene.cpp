#include "player/scene/posed_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "formats/common/errors.h"
#include "player/frame/find_by_name.h"
#include "player/frame/shot.h"
#include "sh/light_rotation.h"

namespace penumbra {

namespace {

Affine placed(const SceneCharacter& one) {
    const double angle = one.yaw * std::numbers::pi / 180;
    const auto c = float(std::cos(angle)), s = float(std::sin(angle));
    const Vec3 p = one.position;
    return {{c, 0, s, p.x, 0, 1, 0, p.y, -s, 0, c, p.z}};
}

// The sampled frame nearest to a time of the clip.
std::size_t frameAt(const AnimationView& animation, const ClipView& clip, double seconds) {
    std::size_t best = clip.first_frame;
    for (std::size_t f = clip.first_frame; f < clip.first_frame + clip.frame_count; ++f)
        if (std::abs(animation.times[f] - seconds) < std::abs(animation.times[best] - seconds)) best = f;
    return best;
}

// Finds what a scene names in an asset.
template <class T>
std::size_t named(const std::vector<T>& list, const std::string& name, const std::string& at) try {
    return findByName(list, name, at);
} catch (const UsageError& error) {
    throw InvalidInput(error.what());
}

}  // namespace

PosedScene::PosedScene(SceneDescription file) : file_(std::move(file)) {
    std::map<std::filesystem::path, std::shared_ptr<const OpenAsset>> open;
    const auto opened = [&](const std::filesystem::path& path) {
        std::shared_ptr<const OpenAsset>& asset = open[path.lexically_normal()];
        if (!asset) asset = std::make_shared<const OpenAsset>(path);
        return asset;
    };
    std::map<const OpenAsset*, const Evaluator*> decoded;
    std::vector<const Evaluator*> casters;
    for (const std::vector<SceneCharacter>* list : {&file_.characters, &file_.props})
        for (const SceneCharacter& one : *list) {
            std::shared_ptr<const OpenAsset> asset = opened(one.asset);
            if (!asset->view.has_model) throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no model");
            if (!one.material.empty()) named(asset->view.materials, one.material, one.at + "/material");
            requireFrames(asset->view);
            const Evaluator*& first = decoded[asset.get()];
            // Copies share what is decoded.
            Evaluator evaluator = first ? *first : Evaluator(asset->view);
            members_.push_back(std::make_unique<SceneMember>(
                SceneMember{&one, std::move(asset), std::move(evaluator), 0, placed(one), kNobody}));
            SceneMember& member = *members_.back();
            first = &member.evaluator;
            if (!member.evaluator.composed()) continue;
            member.caster = casters.size();
            casters.push_back(&member.evaluator);
        }
    try {
        cast_ = std::make_unique<CastShadow>(casters);
    } catch (const std::length_error& error) {
        throw Unsupported(error.what());
    }
    light_asset_ = file_.light.asset.empty() ? members_.front()->asset : opened(file_.light.asset);
    if (light_asset_->view.lights.empty() && (!file_.light.name.empty() || !file_.light.asset.empty()))
        throw InvalidInput(file_.light.at + ": " +
                           (file_.light.asset.empty() ? members_.front()->file->asset : file_.light.asset).string() +
                           " has no light");
    if (!light_asset_->view.lights.empty())
        light_ = named(light_asset_->view.lights, file_.light.name, file_.light.at + "/name");
    try {
        light_rotation_ = parseLightRotation(file_.light.rotation);
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(file_.light.at + "/rotation: " + error.what());
    }
    pose({});
}

void PosedScene::pose(std::optional<double> seconds) {
    for (const std::unique_ptr<SceneMember>& member : members_) {
        const AnimationView& animation = member->asset->view.animation;
        const std::size_t clip = named(animation.clips, member->file->clip, member->file->at + "/clip");
        member->frame = frameAt(animation, animation.clips[clip], seconds.value_or(member->file->seconds));
        member->evaluator.setFrame(member->frame);
        if (member->caster != kNobody) cast_->pose(member->caster, member->to_scene);
    }
}

}  // namespace penumbra
