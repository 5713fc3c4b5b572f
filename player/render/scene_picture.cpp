#include "player/render/scene_picture.h"

#include "player/draw/sky_painter.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_frames.h"
#include "player/render/scene_on_gpu.h"
#include "player/render/sunlight_of_scene.h"

namespace penumbra {

namespace {

// Returns the suns of frames with their maps.
std::optional<Sunlight> shiningSuns(const PosedScene& scene, const RenderOptions& options, const auto& frames) {
    std::optional<Sunlight> suns = sunlightOf(scene, frames, options.sun_map);
    if (suns) suns->shine(frames.suns(), frames.sunCasters());
    return suns;
}

FrameView drawValues(const PosedScene& scene, const RenderOptions& options, int threads, const AssetView* truth,
                     const OffscreenTarget& target) {
    SceneFrames frames(scene, options, threads, truth);
    frames.evaluateMembers();
    frames.evaluateGround();
    frames.frameCamera();
    frames.shade();
    const std::optional<Sunlight> suns = shiningSuns(scene, options, frames);
    target.begin();
    for (const SceneMesh& mesh : frames.meshes()) {
        const BrdfModels sunlit = suns ? frames.lobes().models(mesh.surface.lobes) : 0;
        ValuePainter painter = mesh.mesh ? ValuePainter(*mesh.mesh, mesh.channel, mesh.sides, sunlit, mesh.shading)
                                         : ValuePainter(mesh.triangles, mesh.channel, mesh.sides, sunlit);
        painter.upload(mesh.positions, mesh.values, mesh.surface);
        painter.draw(frames.view(), suns ? &*suns : nullptr);
    }
    return frames.view();
}

FrameView drawOnGpu(const PosedScene& scene, const RenderOptions& options, int threads, const OffscreenTarget& target) {
    SceneOnGpu gpu(scene, options, threads);
    gpu.evaluate();
    const std::optional<Sunlight> suns = shiningSuns(scene, options, gpu);
    target.begin();
    gpu.draw(gpu.view(), suns ? &*suns : nullptr);
    return gpu.view();
}

Image drawSky(const PosedScene& scene, const FrameView& view, const OffscreenTarget& target) {
    SkyPainter sky;
    sky.upload(skyPicture(*scene.light()));
    Mat3 rotation;
    for (std::size_t i = 0; i < 9; ++i) rotation.m[i] = float(scene.lightRotation().m[i]);
    target.begin();
    sky.draw(view, rotation);
    return target.read();
}

}  // namespace

ScenePicture drawScene(const PosedScene& scene, const RenderOptions& options, int threads, const AssetView* truth) {
    requireLight(scene, options.channel);
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    const EvaluationPath path = options.path.value_or(context->software ? EvaluationPath::kCpu : EvaluationPath::kGlsl);
    const OffscreenTarget target(options.width, options.height, options.samples);
    const FrameView view = path == EvaluationPath::kGlsl && fitsGpu(scene, options)
                               ? drawOnGpu(scene, options, threads, target)
                               : drawValues(scene, options, threads, truth, target);
    ScenePicture picture{target.read(), {}};
    if (options.light_background && options.channel == Channel::kShaded) picture.sky = drawSky(scene, view, target);
    return picture;
}

}  // namespace penumbra
