#include "player/render/scene_on_gpu.h"

#include <map>
#include <numbers>

#include "player/render/scene_frames.h"

namespace penumbra {

namespace {

// Returns the weight of each number of a ground vertex in what it shows.
std::vector<Vec3> shownWeights(const PosedScene& scene, const LightView& light, const GroundVertices& ground,
                               Channel channel) {
    std::vector<Vec3> out;
    if (channel == Channel::kShaded) {
        const Vec3d reflected = toDouble(scene.file().ground->albedo) * (1 / std::numbers::pi);
        for (const Vec3d& w : groundWeights(ground, light, scene.lightRotation()))
            out.push_back(toFloat(reflected * w));
        return out;
    }
    std::array<float, kFarCoefficients> weights;
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    for (const float w : weights) out.push_back({w, 0, 0});
    return out;
}

}  // namespace

bool fitsGpu(const PosedScene& scene, const RenderOptions& options) {
    const SceneDescription& file = scene.file();
    const bool plain = std::ranges::none_of(file.props, &SceneCharacter::real) && !scene.members().empty() &&
                       !(file.ground && file.ground->catcher);
    return plain && !scene.groundCasts() && options.channel != Channel::kError &&
           scene.castWay().mode == CastMode::kProduct;
}

SceneOnGpu::SceneOnGpu(const PosedScene& scene, const RenderOptions& options, int threads)
    : scene_(scene), options_(options), threads_(threads), members_(scene.members().size()) {
    requireLight(scene, options.channel);
    for (const std::unique_ptr<SceneMember>& member : scene.members()) {
        looks_.push_back(std::make_unique<SceneLook>(scene, *member, options));
        SceneLook& look = *looks_.back();
        // The GPU shades in the model frame.
        if (look.shading)
            look.shading->setLightRotation(transposed(member->to_scene.linear()) * look.shot.light_rotation);
        if (member->caster == kNobody) continue;
        casters_.push_back({&member->evaluator, *casterKindOf(*member->file, member->evaluator), member->to_scene});
    }
    sunlight_ = sceneSunlight(scene, looks_);
    cast_.emplace(casters_);
    makeGroups();
    if (scene.field())
        makeHeights();
    else if (scene.file().ground)
        makeGround();
}

void SceneOnGpu::makeGroups() {
    std::map<const OpenAsset*, std::size_t> group_of;
    for (std::size_t m = 0; m < looks_.size(); ++m) {
        const SceneMember& member = *scene_.members()[m];
        const SceneLook& look = *looks_[m];
        const auto [found, is_new] = group_of.try_emplace(member.asset.get(), groups_.size());
        if (is_new) {
            const ShadingSet* shading = look.shading ? &*look.shading : nullptr;
            groups_.emplace_back().asset = std::make_shared<GlAsset>(look.view, shading, &member.evaluator);
        }
        groups_[found->second].members.push_back(m);
    }
    for (Group& group : groups_) group.painter.emplace(group.asset, group.members.size());
}

void SceneOnGpu::makeGround() {
    const GroundVertices ground = groundVertices(*scene_.file().ground, CastShadow({}), threads_);
    ground_weights_ = shownWeights(scene_, sunlight_.light, ground, options_.channel);
    std::optional<SlotLobes> lobes;
    if (!sunlight_.suns.empty()) lobes = sunlight_.lobes.slotLobes(sunlight_.ground);
    ground_.emplace(GroundMesh{ground.positions, ground.normals, ground.tangents, ground.triangles}, options_.channel,
                    lobes);
}

void SceneOnGpu::makeHeights() {
    const SceneField& field = *scene_.field();
    const SceneGround& ground = *scene_.file().ground;
    heights_.emplace(field.heights().field(), ground.heights->order, ground.heights->step, field.tolerance(),
                     field.heights().corner());
    cast_->setHeights(&*heights_);
    std::optional<GroundLobes> lobes;
    if (options_.channel == Channel::kShaded) {
        field_shading_.emplace(ground, field.convention(), scene_.lightAsset(), sunlight_.light);
        field_shading_->set().setLightRotation(sunlight_.light_rotation);
        if (!sunlight_.suns.empty()) {
            field_triangles_ = castingTriangles(field.heights().field().grid());
            const LobeRange range = sunlight_.lobes.add(fieldLobes(ground, scene_.lightAsset()));
            lobes = GroundLobes{sunlight_.lobes.slotLobes(range), sunlight_.lobes.models({&range, 1})};
        }
    }
    heights_ground_.emplace(*heights_, fieldTriangles(field.heights().field().grid()),
                            field_shading_ ? &field_shading_->set() : nullptr, lobes);
}

void SceneOnGpu::evaluate(Group& group) {
    posed_.clear();
    for (const std::size_t m : group.members) {
        const SceneMember& member = *scene_.members()[m];
        PosedCharacter& posed = posed_.emplace_back();
        posed.evaluator = &member.evaluator;
        posed.to_scene = member.to_scene;
        posed.caster = member.caster;
        if (looks_[m]->shading) posed.shading = &*looks_[m]->shading;
        posed.lobes = looks_[m]->slot_lobes;
        if (!group.asset->needsCoefficients()) continue;
        evaluateCoefficients(member.evaluator, threads_, members_[m]);
        posed.coefficients = members_[m].coefficients;
    }
    group.painter->evaluate(options_.channel, posed_, view_.eye, &*cast_);
}

void SceneOnGpu::evaluate() {
    for (std::size_t m = 0; m < members_.size(); ++m) skinMember(*scene_.members()[m], threads_, members_[m]);
    view_ = sceneView(scene_, options_, members_);
    cast_->pose(casters_);
    if (heights_) heights_->update(scene_.field()->takeChanged());
    if (heights_ && !suns().empty()) scene_.field()->heights().castingPoints(field_points_);
    for (Group& group : groups_) evaluate(group);
    if (ground_) ground_->evaluate(*cast_, ground_weights_);
    if (heights_ground_) heights_ground_->evaluate(&*cast_, view_.eye);
    cast_->release();
}

SunCasters SceneOnGpu::sunCasters() const {
    SunCasters casters;
    for (std::size_t m = 0; m < members_.size(); ++m)
        if (castsInSuns(*scene_.members()[m]->file))
            casters.members.push_back({members_[m].positions, looks_[m]->view.mesh.castingTriangles()});
    if (heights_) {
        casters.ground = {field_points_, field_triangles_};
        casters.ground_version = scene_.field()->version();
    }
    return casters;
}

void SceneOnGpu::draw(const FrameView& view, const Sunlight* suns) const {
    for (const Group& group : groups_) group.painter->draw(view, suns);
    if (ground_) ground_->draw(view, suns);
    if (heights_ground_) heights_ground_->draw(view, suns);
}

}  // namespace penumbra
