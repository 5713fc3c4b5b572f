#include "player/view/view_sunlight.h"

#include <algorithm>

#include "player/frame/mirror_sight.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_light.h"
#include "player/view/view_shapes.h"

namespace penumbra {

ViewSunlight::ViewSunlight(const Scene& scene) : scene_(&scene), sunlight_(table_), casters_(scene.characters.size()) {
    if (!scene.ground_file) return;
    if (scene.field) {
        ground_.assign(kTileShades.size(), table_.add(fieldLobes(*scene.ground_file, scene.characters.front()->asset)));
        return;
    }
    for (const float shade : kTileShades) {
        const BrdfLobe paint{BrdfModel::kLambert, {}, scene.ground_file->albedo * shade};
        ground_.push_back(table_.add({&paint, 1}));
    }
}

LobeRange ViewSunlight::groundLobes(float shade) const {
    return ground_[std::size_t(std::ranges::find(kTileShades, shade) - kTileShades.begin())];
}

// Returns whether a material has changed.
bool ViewSunlight::updateLobes() {
    bool changed = false;
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        const ShadingSet& shading = *scene_->characters[i]->shading;
        if (casters_[i].material_version == shading.materialVersion()) continue;
        casters_[i].lobes = table_.add(shading);
        casters_[i].slot_lobes = table_.addSlots(shading);
        casters_[i].material_version = shading.materialVersion();
        changed = true;
    }
    return changed;
}

void ViewSunlight::placeCasters() {
    if (scene_->field) {
        scene_->field->heights().castingPoints(field_points_);
        if (field_triangles_.empty()) field_triangles_ = castingTriangles(scene_->field->heights().field().grid());
    }
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        const Character& character = *scene_->characters[i];
        casters_[i].positions.clear();
        for (const Vec3 p : character.vertices.positions) casters_[i].positions.push_back(character.to_scene.point(p));
    }
}

void ViewSunlight::shine(const ViewState& state) {
    const Shone now{scene_->pose_version, shownLightKey(*scene_, state), lightRotation(state)};
    if (!updateLobes() && shone_ == now) return;
    if (!shone_ || shone_->pose_version != now.pose_version) placeCasters();
    std::vector<SunCaster> casters;
    for (std::size_t i = 0; i < casters_.size(); ++i)
        casters.push_back({casters_[i].positions, scene_->characters[i]->asset.mesh.triangles});
    if (scene_->field) casters.push_back({field_points_, field_triangles_});
    if (reflected_ != now.light) sunlight_.reflect(shownSky(*scene_, state));
    reflected_ = now.light;
    sunlight_.turnSky(now.rotation);
    gl::Disable(GL_SCISSOR_TEST);
    sunlight_.shine(sunsOf(shownLight(*scene_, state), now.rotation), casters);
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    shone_ = now;
}

SunlitSurface ViewSunlight::surfaceOf(std::size_t index, Vec3 eye, std::span<Vec3> values) {
    const Character& character = *scene_->characters[index];
    Caster& caster = casters_[index];
    const FrameVertices& vertices = character.vertices;
    const ModelView& model = character.asset.model;
    caster.sight = takeMirrorsOut(model.convention, model.stride, vertices, eye, 0, table_, caster.lobes, values);
    return {vertices.normals, vertices.tangents, caster.lobes, caster.sight};
}

SunlitSurface ViewSunlight::fieldSurface(Vec3 eye, std::span<Vec3> values) {
    const FrameVertices& points = scene_->ground.points;
    field_lobes_.assign(values.size(), groundLobes(1));
    field_sight_ =
        takeMirrorsOut(scene_->field->convention(), kFieldStride, points, eye, 0, table_, field_lobes_, values);
    return {points.normals, points.tangents, field_lobes_, field_sight_};
}

}  // namespace penumbra
