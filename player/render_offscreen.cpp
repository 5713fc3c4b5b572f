#include "player/render_offscreen.h"

#include <algorithm>
#include <cmath>

#include "player/draw_frame.h"
#include "player/frame_values.h"
#include "player/model_painter.h"
#include "player/offscreen_target.h"
#include "player/picture_view.h"

namespace penumbra {

static RenderResult::Error statistics(std::span<const float> e, std::span<const float> truth) {
    RenderResult::Error error;
    for (std::size_t v = 0; v < e.size(); ++v) {
        const double difference = std::abs(double(e[v]) - double(truth[v]));
        error.mean += difference / double(e.size());
        error.max = std::max(error.max, difference);
    }
    return error;
}

// The background behind pixels that the mesh covers in part or not at all.
static void putBehind(Image& image, Vec3 background) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += background * (1 - image.alpha[i]);
    image.alpha.clear();
}

RenderResult renderOffscreen(const RenderOptions& options, const AssetView& asset, const AssetView* truth,
                             int threads) {
    const Shot shot = resolveShot(options, asset, truth);
    Evaluator evaluator(asset);
    FrameVertices vertices;
    evaluateFrame(shot, options.source, evaluator, threads, vertices);
    const FrameView view = makePictureView(options, asset, vertices.positions);
    RenderResult result;
    result.out_of_range = evaluator.outOfRange();
    std::vector<float> true_ambient;
    if (options.channel == Channel::kError) {
        true_ambient = trueAmbient(shot, vertices, threads);
        result.ambient_error = statistics(ambientOf(shot, vertices.numbers, threads), true_ambient);
    }

    std::optional<ShadingSet> shading;
    if (shot.shaded) shading.emplace(shadingOf(shot));
    const ShadingSet* shading_view = shading ? &*shading : nullptr;
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    result.gl = context->description;
    result.path = options.path.value_or(context->software ? EvaluationPath::kCpu : EvaluationPath::kGlsl);
    const OffscreenTarget target(options.width, options.height, options.samples);
    if (result.path == EvaluationPath::kCpu) {
        const ValuePainter painter(asset.mesh.triangles, options.channel);
        const std::vector<Vec3> values =
            channelValues(shot, options.channel, shading_view, vertices, true_ambient, view.eye, threads);
        target.begin();
        painter.draw(view, vertices.positions, values);
    } else {
        ModelPainter painter(std::make_shared<GlAsset>(asset, shading_view), 1);
        PosedCharacter character{&evaluator, {}, shading_view};
        if (options.source == VisibilitySource::kTruth) character.numbers = vertices.numbers;
        character.true_ambient = true_ambient;
        painter.evaluate(options.channel, {&character, 1}, view.eye);
        target.begin();
        painter.draw(view);
    }
    result.image = target.read();
    if (options.background) putBehind(result.image, *options.background);
    return result;
}

}  // namespace penumbra
