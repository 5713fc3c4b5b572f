#include "player/view/view_backdrop.h"

namespace penumbra {

bool showsGround(const Scene& scene, const ViewState& state) {
    return state.ground && scene.ground_file && scene.ground.version > 0 &&
           cameraPosition(state.camera).y >= scene.ground_file->height;
}

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

void Backdrop::drawGround(const Scene& scene, const FrameView& view) {
    const ShownGround& ground = scene.ground;
    if (!ground_) {
        tiles_ = groundTiles(ground.vertices.side);
        ground_.emplace(tiles_.triangles, Channel::kShaded);
    }
    if (ground_version_ != ground.version) {
        std::vector<Vec3> positions, values;
        for (std::size_t v = 0; v < tiles_.vertices.size(); ++v) {
            positions.push_back(ground.vertices.positions[tiles_.vertices[v]]);
            values.push_back(ground.values[tiles_.vertices[v]] * tiles_.shades[v]);
        }
        ground_->upload(positions, values);
        ground_version_ = ground.version;
    }
    FrameView plain = view;
    if (!ground.lit()) plain.display = DisplayTransform();
    ground_->draw(plain);
}

void Backdrop::draw(const Scene& scene, const ViewState& state, const FrameView& view, double aspect) {
    const ShadingSet* shading = scene.characters.front()->shading.get();
    if (state.background && shading && state.channel == Channel::kShaded && !state.component &&
        shownCompare(state) != Compare::kDifference)
        drawSky(*shading, state, view, aspect);
    if (showsGround(scene, state)) drawGround(scene, view);
}

}  // namespace penumbra
