#include "player/scene/posed_scene.h"

#include <algorithm>
#include <map>

#include "formats/cache/still_mesh.h"
#include "formats/common/errors.h"
#include "formats/scene/scene_origin.h"
#include "formats/scene/scene_placement.h"
#include "runtime/papers/refuse_transfer.h"

namespace penumbra {

std::optional<CasterKind> casterKindOf(const SceneCharacter& one, const Evaluator& evaluator) {
    const std::string at = one.at + "/casts: " + one.asset.string();
    if (one.casts == SceneCasts::kFields && !evaluator.composed())
        throw InvalidInput(at + " has no fields; a composed model brings them");
    if (one.casts == SceneCasts::kSpheres && evaluator.asset().blockers.spheres.empty())
        throw InvalidInput(at + " has no spheres; penumbra-pack asset takes those of penumbra-fit blockers");
    if (one.casts == SceneCasts::kNothing) return std::nullopt;
    if (one.casts == SceneCasts::kWhatItHas) return casterKindOf(evaluator);
    return one.casts == SceneCasts::kFields ? CasterKind::kFields : CasterKind::kSpheres;
}

namespace {

RealMesh placedMesh(const SceneCharacter& one) {
    StillMesh mesh = readStillMesh(one.asset);
    const Affine to_scene = placementOf(one);
    for (Vec3& p : mesh.positions) p = to_scene.point(p);
    return {&one, std::move(mesh.positions), std::move(mesh.triangles)};
}

}  // namespace

PosedScene::PosedScene(SceneDescription file, const CastWay& way) : way_(way), file_(std::move(file)) {
    if (needsSpheres(way_.mode)) castBySpheres(file_);
    if (file_.ground && file_.ground->heights && way_.mode != CastMode::kProduct)
        throw BadOption("cast", file_.ground->heights->source.at + ": a ground with heights joins as a product alone");
    if (std::optional<GroundHeights> heights = openGround(file_))
        field_ = std::make_unique<SceneField>(*file_.ground, std::move(*heights));
    std::map<std::filesystem::path, std::shared_ptr<const OpenAsset>> open;
    const auto opened = [&](const std::filesystem::path& path) {
        std::shared_ptr<const OpenAsset>& asset = open[path.lexically_normal()];
        if (!asset) asset = std::make_shared<const OpenAsset>(path);
        return asset;
    };
    // An asset that cannot be read says who wants it.
    const auto openedAt = [&](const SceneCharacter& one) {
        try {
            const std::shared_ptr<const OpenAsset> asset = opened(one.asset);
            refuseTransfer<InvalidInput>(asset->view, "has linear transfer, on which nothing casts");
            return asset;
        } catch (const IoError& error) {
            throw IoError(one.at + "/asset: " + error.what());
        } catch (const InvalidInput& error) {
            throw InvalidInput(one.at + "/asset: " + error.what());
        }
    };
    std::map<const OpenAsset*, const Evaluator*> decoded;
    std::vector<const Evaluator*> casters;
    std::vector<CasterKind> kinds;
    for (const std::vector<SceneCharacter>* list : {&file_.characters, &file_.props})
        for (const SceneCharacter& one : *list) {
            if (isRealMesh(one)) {
                meshes_.push_back(placedMesh(one));
                continue;
            }
            std::shared_ptr<const OpenAsset> asset = openedAt(one);
            if (!asset->view.has_model) throw InvalidInput(one.at + "/asset: " + one.asset.string() + " has no model");
            if (!one.material.empty() || !one.slots.empty()) (void)materialsOf(one, asset->view);
            const Evaluator*& first = decoded[asset.get()];
            // Copies share what is decoded.
            Evaluator evaluator = first ? *first : Evaluator(asset->view);
            members_.push_back(std::make_unique<SceneMember>(
                SceneMember{&one, std::move(asset), std::move(evaluator), 0, placementOf(one), kNobody}));
            SceneMember& member = *members_.back();
            first = &member.evaluator;
            if (one.pose) member.pose = &poses_.poseOf(one, member.asset->view);
            const std::optional<CasterKind> kind = casterKindOf(one, member.evaluator);
            if (!kind) continue;
            member.caster = casters.size();
            kinds.push_back(*kind);
            casters.push_back(&member.evaluator);
        }
    try {
        cast_ = std::make_unique<CastShadow>(casters, kinds);
    } catch (const std::length_error& error) {
        throw Unsupported(error.what());
    }
    cast_->setExponential(way_.exponential);
    if (!way_.exponential.isDefault() && std::ranges::find(kinds, CasterKind::kSpheres) == kinds.end())
        throw BadOption("cast_exponential", "nobody in the scene casts by spheres");
    if (!file_.light.asset.empty())
        light_asset_ = opened(file_.light.asset);
    else if (!members_.empty())
        light_asset_ = members_.front()->asset;
    if (light_asset_) light_ = lightOf(file_.light, light_asset_->view);
    light_rotation_ = rotationOf(file_.light);
    pose({});
}

void PosedScene::addDarkSun() {
    static const Sun kDark{};  // above, without light
    if (!light_ || !light_->suns.empty()) return;
    dark_asset_ = light_asset_->view;
    has_dark_sun_ = true;
    for (LightView& light : dark_asset_.lights)
        if (light.suns.empty()) light.suns = {&kDark, 1};
    light_ = lightOf(file_.light, dark_asset_);
}

// Brings who stands on the ground to the height of what lies below its pose.
void PosedScene::place(SceneMember& member) {
    if (!member.file->on_ground) return;
    member.to_scene = placementOf(*member.file);
    const GroundHeights* heights = field_ ? &field_->heights() : nullptr;
    if (heights) skinFrame(member.evaluator, 1, standing_);
    member.to_scene.m[7] += standingHeight(*member.file, standing_.positions, member.to_scene, file_.ground, heights);
}

void PosedScene::pose(std::optional<double> seconds) {
    if (field_) field_->pose(seconds);
    for (std::size_t m = 0; m < members_.size(); ++m) {
        const std::unique_ptr<SceneMember>& member = members_[m];
        const bool moves = m < file_.characters.size();  // members that are meshes are props
        if (member->pose) {
            member->evaluator.setPose(member->pose->bones, member->pose->rotations);
        } else {
            member->frame = frameOf(*member->file, member->asset->view.animation, moves ? seconds : std::nullopt);
            member->evaluator.setFrame(member->frame);
        }
        place(*member);
        if (member->caster != kNobody) cast_->pose(member->caster, member->evaluator.bones(), member->to_scene);
    }
}

}  // namespace penumbra
