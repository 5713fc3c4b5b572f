#include "player/view/view_backdrop.h"

#include <numbers>

namespace penumbra {

// Draws with the camera's own view from the origin of a sphere around it. Depth is clamped, as the sphere has no
// place.
void Backdrop::drawSky(const ShadingSet& shading, const ViewState& state, const FrameView& view, double aspect) {
    if (!sky_) {
        sphere_ = unitSphere(32);
        sky_.emplace(sphere_.triangles, Channel::kShaded);
    }
    const Made made{shading.light(), shading.lightVersion()};
    if (sky_made_ != made) {
        const LightView& light = shading.asset().lights[shading.light()];
        sky_->upload(sphere_.positions, radianceFrom(light, lightRotation(state), sphere_.positions));
        sky_made_ = made;
    }
    Camera camera = state.camera;
    camera.target = camera.target - cameraPosition(camera);
    FrameView sky = view;
    clipFromModel(camera, aspect, 1, sky.clip_from_model);
    gl::Enable(GL_DEPTH_CLAMP);
    sky_->draw(sky);
    gl::Disable(GL_DEPTH_CLAMP);
    gl::Clear(GL_DEPTH_BUFFER_BIT);
}

void Backdrop::drawGround(const Scene& scene, const ViewState& state, const FrameView& view) {
    const ShadingSet* shading = scene.characters.front()->shading.get();
    const bool lit = shading && state.channel == Channel::kShaded && !state.component;
    const Made made = lit ? Made{shading->light(), shading->lightVersion()} : Made{};
    if (!ground_ || ground_made_ != made) {
        Vec3 radiance{0.5f, 0.5f, 0.5f};
        if (lit)
            radiance = irradianceFromAbove(shading->asset().lights[shading->light()], lightRotation(state)) /
                       std::numbers::pi_v<float>;
        const BoundingBox box = restBounds(scene);
        ground_height_ = box.low.y;
        const Shape ground = groundPlane(box, radiance);
        if (!ground_) ground_.emplace(ground.triangles, Channel::kShaded);
        ground_->upload(ground.positions, ground.values);
        ground_made_ = made;
    }
    if (view.eye.y < ground_height_) return;  // from below it would hide the characters
    FrameView plain = view;
    if (!lit) plain.display = DisplayTransform();
    ground_->draw(plain);
}

void Backdrop::draw(const Scene& scene, const ViewState& state, const FrameView& view, double aspect) {
    const ShadingSet* shading = scene.characters.front()->shading.get();
    if (state.background && shading && state.channel == Channel::kShaded && !state.component &&
        shownCompare(state) != Compare::kDifference)
        drawSky(*shading, state, view, aspect);
    if (state.ground) drawGround(scene, state, view);
}

}  // namespace penumbra
