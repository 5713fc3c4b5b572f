#include "player/view/view_field.h"

#include <cmath>
#include <numbers>

#include "player/view/view_look.h"

namespace penumbra {

namespace {

// Without a light a ground is half of its colour where it sees the whole sky: it is Lambertian under a sky of 1/2.
const std::array<float, 3> kHalfSky = [] {
    const auto y0 = float(0.5 * std::sqrt(4 * std::numbers::pi));
    return std::array<float, 3>{y0, y0, y0};
}();

SceneGround plainGround(const SceneGround& ground) {
    SceneGround plain = ground;
    plain.material.clear();
    return plain;
}

}  // namespace

ViewField::ViewField(const Scene& scene)
    : scene_(&scene),
      heights_(scene.field->heights().field(), scene.ground_file->heights->order, scene.ground_file->heights->step,
               scene.field->tolerance(), scene.field->heights().corner()) {}

void ViewField::update() { heights_.update(scene_->field->takeChanged()); }

ViewField::Shown& ViewField::shownAs(const Look& look, const ViewSunlight* suns) {
    std::unique_ptr<Shown>& shown = shown_[look];
    if (shown) return *shown;
    const SceneGround& ground = *scene_->ground_file;
    const AssetView& asset = scene_->characters.front()->asset;
    const Convention convention = scene_->field->convention();
    if (look.lit) {
        // Room for the light of the largest order.
        LightView room = asset.lights.back();
        room.suns = {};
        shown = std::make_unique<Shown>(ground, convention, asset, room);
    } else {
        shown = std::make_unique<Shown>(plainGround(ground), convention, asset, LightView{"sky", 1, kHalfSky});
    }
    std::optional<GroundLobes> lobes;
    if (look.sunlit) lobes = GroundLobes{suns->fieldSlotLobes(), suns->groundModels()};
    shown->ground.emplace(heights_, fieldTriangles(heights_.field().grid()), &shown->shading.set(), lobes);
    return *shown;
}

void ViewField::evaluate(const ViewState& state, Vec3 eye, GlCast& cast, const ViewSunlight* suns) {
    last_ = {scene_->ground.lit(), suns != nullptr};
    Shown& shown = shownAs(last_, suns);
    ShadingSet& set = shown.shading.set();
    if (last_.lit) {
        shown.light.update(shownLightKey(*scene_, state),
                           [&](auto&) { set.replaceLight(0, shownLight(*scene_, state)); });
        if (set.sunsOn() != last_.sunlit) set.setSuns(last_.sunlit);
        if (set.lightRotation() != lightRotation(state)) set.setLightRotation(lightRotation(state));
    }
    shown.ground->evaluate(&cast, eye);
}

void ViewField::draw(const FrameView& view, const Sunlight* suns) const { shown_.at(last_)->ground->draw(view, suns); }

}  // namespace penumbra
