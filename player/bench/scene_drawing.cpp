#include "player/bench/scene_drawing.h"

#include "player/render/sunlight_of_scene.h"

namespace penumbra {

SceneDrawing::SceneDrawing(const PosedScene& scene, const SceneFrames& frames, const RenderOptions& options)
    : frames_(&frames),
      target_(options.width, options.height, options.samples, GL_RGBA8),
      suns_(sunlightOf(scene, frames, options.sun_map)) {
    for (const SceneMesh& mesh : frames.meshes()) {
        const Sides sides = mesh.sides == Sides::kBoth && !mesh.is_ground ? Sides::kSeen : mesh.sides;
        const BrdfModels sunlit = suns_ ? frames.lobes().models(mesh.surface.lobes) : 0;
        if (mesh.mesh)
            painters_.emplace_back(*mesh.mesh, options.channel, sides, sunlit, mesh.shading);
        else
            painters_.emplace_back(mesh.triangles, options.channel, sides, sunlit);
    }
}

void SceneDrawing::drawMaps() {
    if (suns_) suns_->shine(frames_->suns(), frames_->sunCasters());
}

void SceneDrawing::drawMeshes() {
    FrameView view = frames_->view();
    view.display = DisplayTransform();
    target_.begin();
    const std::vector<SceneMesh> meshes = frames_->meshes();
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (meshes[i].is_ground) painters_[i].setTriangles(meshes[i].triangles);
        painters_[i].upload(meshes[i].positions, meshes[i].values, meshes[i].surface);
        painters_[i].draw(view, suns_ ? &*suns_ : nullptr);
    }
}

}  // namespace penumbra
