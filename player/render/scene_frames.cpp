#include "player/render/scene_frames.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/scene/scene_placement.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

AssetView litView(const PosedScene& scene, const SceneMember& member) {
    AssetView view = member.asset->view;
    view.lights = scene.lightAsset().lights;
    return view;
}

Shot lookOf(const PosedScene& scene, const SceneMember& member, const RenderOptions& options, const AssetView& view) {
    RenderOptions look;
    look.channel = options.channel;
    look.shading = options.shading;
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

SceneFrames::Look::Look(const PosedScene& scene, const SceneMember& member, const RenderOptions& options)
    : view(litView(scene, member)), shot(lookOf(scene, member, options, view)) {
    if (shot.shaded) shading.emplace(shadingOf(shot));
}

SceneFrames::SceneFrames(const PosedScene& scene, const RenderOptions& options, int threads)
    : scene_(scene), options_(options), threads_(threads) {
    if (options.channel == Channel::kShaded && !scene.light())
        throw UsageError("the scene has no light: name an asset that has one under \"light\", or ask for --channel ao");
    for (const std::unique_ptr<SceneMember>& member : scene.members())
        looks_.push_back(std::make_unique<Look>(scene, *member, options));
    members_.resize(looks_.size());
    values_.resize(looks_.size() + (scene.file().ground ? 1 : 0));
}

void SceneFrames::evaluateMembers() {
    for (std::size_t m = 0; m < members_.size(); ++m) memberVertices(scene_, m, threads_, members_[m]);
}

void SceneFrames::evaluateGround() {
    if (scene_.file().ground) ground_ = groundVertices(scene_, threads_);
}

void SceneFrames::findView() {
    std::vector<Vec3> corners;
    for (const FrameVertices& vertices : members_) {
        const BoundingBox box = boundsOf(vertices.positions);
        corners.insert(corners.end(), {box.low, box.high});
    }
    const double radius = std::max<double>(boundsOf(corners).radius(), 1e-3);
    const double reach = scene_.file().ground ? std::max(radius, scene_.file().ground->size) : radius;
    const Camera camera = cameraOf(scene_.file(), options_.camera, corners);
    clipFromModel(camera, double(options_.width) / options_.height, reach, view_.clip_from_model);
    view_.eye = toFloat(cameraPosition(camera));
}

void SceneFrames::shade() {
    findView();
    for (std::size_t m = 0; m < members_.size(); ++m) {
        Look& look = *looks_[m];
        values_[m] = channelValues(look.shot, options_.channel, look.shading ? &*look.shading : nullptr, members_[m],
                                   {}, view_.eye, threads_);
    }
    if (!scene_.file().ground) return;
    if (options_.channel == Channel::kShaded) {
        values_.back() = groundRadiance(scene_, ground_);
        return;
    }
    values_.back().clear();
    for (const float e : groundAmbient(ground_)) values_.back().push_back({e, 0, 0});
}

std::vector<SceneMesh> SceneFrames::meshes() const {
    std::vector<SceneMesh> out;
    for (std::size_t m = 0; m < members_.size(); ++m)
        out.push_back({looks_[m]->view.mesh.triangles, members_[m].positions, values_[m],
                       looks_[m]->view.mesh.two_sided ? Sides::kFront : Sides::kBoth});
    if (scene_.file().ground) out.push_back({ground_.triangles, ground_.positions, values_.back()});
    return out;
}

}  // namespace penumbra
