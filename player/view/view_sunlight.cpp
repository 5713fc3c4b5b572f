#include "player/view/view_sunlight.h"

#include <algorithm>

#include "player/frame/mirror_sight.h"
#include "player/scene/scene_suns.h"
#include "player/view/view_look.h"
#include "player/view/view_shapes.h"

namespace penumbra {

ViewSunlight::ViewSunlight(const Scene& scene) : scene_(&scene), sunlight_(table_), casters_(scene.characters.size()) {
    addGround();
}

void ViewSunlight::addGround() {
    ground_.clear();
    if (!scene_->ground_file) return;
    if (scene_->field) {
        ground_.assign(kTileShades.size(),
                       table_.add(fieldLobes(*scene_->ground_file, scene_->characters.front()->asset)));
        return;
    }
    for (const float shade : kTileShades) {
        const BrdfLobe paint{BrdfModel::kLambert, {}, scene_->ground_file->albedo * shade};
        ground_.push_back(table_.add({&paint, 1}));
    }
}

LobeRange ViewSunlight::groundLobes(float shade) const {
    return ground_[std::size_t(std::ranges::find(kTileShades, shade) - kTileShades.begin())];
}

// Makes the table anew where a material has changed. It would grow with every step of a slider otherwise.
void ViewSunlight::updateLobes() {
    const auto is_current = [&](std::size_t i) {
        return casters_[i].material_version == scene_->characters[i]->shown.shading->materialVersion();
    };
    std::size_t current = 0;
    while (current < casters_.size() && is_current(current)) ++current;
    if (current == casters_.size()) return;
    table_.clear();
    addGround();
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        const ShadingSet& shading = *scene_->characters[i]->shown.shading;
        Caster& caster = casters_[i];
        const std::vector<SlotLobes> of_slots = table_.addSlots(shading);
        // Where other numbers are at the same place, the vertices need not be told.
        if (of_slots != caster.slot_lobes) caster.lobes = table_.add(shading);
        caster.slot_lobes = of_slots;
        caster.material_version = shading.materialVersion();
    }
    sunlight_.updateLobes();
}

void ViewSunlight::placeCasters() {
    if (scene_->field) {
        scene_->field->heights().castingPoints(field_points_);
        if (field_triangles_.empty()) field_triangles_ = castingTriangles(scene_->field->heights().field().grid());
    }
    for (std::size_t i = 0; i < casters_.size(); ++i) {
        const Character& character = *scene_->characters[i];
        casters_[i].positions.clear();
        for (const Vec3 p : character.posed.vertices.positions)
            casters_[i].positions.push_back(character.posed.to_scene.point(p));
    }
}

void ViewSunlight::shine(const ViewState& state) {
    const SunsKey key = keysOf(*scene_, state).suns;
    updateLobes();
    shone_.update(key, [&](auto&) { draw(state, key); });
}

void ViewSunlight::draw(const ViewState& state, const SunsKey& key) {
    placed_.update({key.everyone, key.field, {}, {}}, [&](auto&) { placeCasters(); });
    SunCasters casters;
    for (std::size_t i = 0; i < casters_.size(); ++i)
        if (const SceneCharacter* file = memberOf(*scene_, i); !file || file->casts != SceneCasts::kNothing)
            casters.members.push_back({casters_[i].positions, scene_->characters[i]->asset.mesh.castingTriangles()});
    if (scene_->field) {
        casters.ground = {field_points_, field_triangles_};
        casters.ground_version = key.field;
    }
    reflected_.update(key.light, [&](auto&) { sunlight_.reflect(shownSky(*scene_, state)); });
    sunlight_.turnSky(key.rotation);
    gl::Disable(GL_SCISSOR_TEST);
    sunlight_.shine(sunsOf(shownLight(*scene_, state), key.rotation), casters);
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
}

SunlitSurface ViewSunlight::surfaceOf(std::size_t index, Vec3 eye, std::span<Vec3> values) {
    const Character& character = *scene_->characters[index];
    Caster& caster = casters_[index];
    const FrameVertices& vertices = character.posed.vertices;
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
