#include "player/render/scene_picture.h"

#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_frames.h"

namespace penumbra {

Image drawScene(const PosedScene& scene, const RenderOptions& options, int threads) {
    SceneFrames frames(scene, options, threads);
    frames.evaluateMembers();
    frames.evaluateGround();
    frames.shade();
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    const OffscreenTarget target(options.width, options.height, options.samples);
    target.begin();
    for (const SceneMesh& mesh : frames.meshes())
        ValuePainter(mesh.triangles, options.channel, mesh.sides).draw(frames.view(), mesh.positions, mesh.values);
    return target.read();
}

}  // namespace penumbra
