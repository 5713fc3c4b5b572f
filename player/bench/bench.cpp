#include "player/bench/bench.h"

#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "player/bench/bench_characters.h"
#include "player/draw/draw_frame.h"
#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/gl/offscreen_target.h"
#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

namespace {

// The benchmark draws this: the asset, a frame of it, and the shading, which may be null.
struct Subject {
    const AssetView* asset = nullptr;
    Channel channel = Channel::kShaded;
    Shot shot;
    ShadingSet* shading = nullptr;
    int threads = 1;
    FrameVertices vertices;
    std::vector<Vec3> values;
    FrameView view;

    SunlitSurface surface() const { return {vertices.normals, vertices.tangents, {}}; }
};

void evaluateValues(Subject& subject, Evaluator& evaluator, std::size_t frame) {
    const bool shaded = subject.channel == Channel::kShaded;
    subject.shot.frame = frame % subject.asset->animation.frameCount();
    evaluator.setFrame(subject.shot.frame);
    skinFrame(evaluator, subject.threads, subject.vertices);
    if (shaded && shadeTransfer(evaluator, *subject.shading, subject.threads, subject.values)) return;
    evaluateSkinned(evaluator, subject.threads, subject.vertices);
    evaluateIndirect(evaluator, subject.threads, subject.vertices.indirect);
    if (shaded)
        shadeFrame(*subject.shading, subject.vertices, subject.view.eye, subject.threads, subject.values);
    else
        subject.values = channelValues(subject.shot, subject.channel, nullptr, subject.vertices, {}, subject.view.eye,
                                       subject.threads);
}

GlBench::WholeFrame timeWholeFrame(Subject& subject, const RenderOptions& options, int samples, int runs) {
    const OffscreenTarget target(options.width, options.height, samples, GL_RGBA8);
    ValuePainter painter(subject.asset->mesh, subject.channel, Sides::kSeen, 0, subject.shading);
    Evaluator evaluator(*subject.asset);
    FrameView view = subject.view;
    view.display = DisplayTransform();
    std::vector<std::uint8_t> picture;
    return {samples, timeRuns(runs, [&](std::size_t run) {
                evaluateValues(subject, evaluator, run);
                target.begin();
                painter.upload(subject.vertices.positions, subject.values, subject.surface());
                painter.draw(view);
                target.readBytes(picture);
            })};
}

// Returns the difference of the pictures as a window shows them, but in floats, over what either path covers.
double pathDifference(const Image& a, const Image& b) {
    double sum = 0;
    std::size_t covered = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        if (a.alpha[i] == 0 && b.alpha[i] == 0) continue;
        const Vec3 d = (a.pixels[i] - b.pixels[i]) * 255.0f;
        sum += double(dot(d, d)) / 3;
        ++covered;
    }
    return std::sqrt(sum / double(std::max<std::size_t>(covered, 1)));
}

void benchModelPainter(Subject& subject, const OffscreenTarget& target, ValuePainter& value_painter, bool software,
                       int runs, GlBench& bench) {
    const std::size_t frames = subject.asset->animation.frameCount();
    Evaluator evaluator(*subject.asset);
    const Clock::time_point start = Clock::now();
    const auto asset = std::make_shared<GlAsset>(*subject.asset, subject.shading, &evaluator);
    ModelPainter painter(asset, 1);
    PosedCharacter character{&evaluator, {}, subject.shading};
    FrameVertices vertices;
    const auto draw = [&](std::size_t run, const FrameView& view) {
        evaluator.setFrame(run % frames);
        if (asset->needsCoefficients()) {  // the CPU evaluates, and the GPU does the rest
            evaluateCoefficients(evaluator, subject.threads, vertices);
            character.coefficients = vertices.coefficients;
        }
        target.begin();
        painter.evaluate(subject.channel, {&character, 1}, view.eye);
        painter.draw(view);
        gl::Finish();
    };
    draw(0, subject.view);  // drivers compile at the first draw
    bench.first_frame = millisecondsSince(start);
    bench.draw_model = timeRuns(runs, [&](std::size_t run) { draw(run, subject.view); }).median;
    bench.model = measureGpuCost(asset, subject.channel, {&character, 1}, subject.view, target, software, runs);
    if (subject.shading)
        bench.switching = timeSwitching(*subject.shading, runs, [&](std::size_t run) { draw(run, subject.view); });
    FrameView shown = subject.view;
    shown.display = DisplayTransform();
    draw(0, shown);
    const Image model = target.read();
    evaluateValues(subject, evaluator, 0);
    target.begin();
    value_painter.upload(subject.vertices.positions, subject.values, subject.surface());
    value_painter.draw(shown);
    bench.path_difference = pathDifference(model, target.read());
}

GlBench benchGl(Subject& subject, const RenderOptions& options, int runs) {
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    GlBench bench;
    bench.context = context->description;
    bench.whole_frames.push_back(timeWholeFrame(subject, options, 1, runs));
    if (options.samples > 1) bench.whole_frames.push_back(timeWholeFrame(subject, options, options.samples, runs));
    const OffscreenTarget target(options.width, options.height, options.samples);
    ValuePainter value_painter(subject.asset->mesh, subject.channel, Sides::kSeen, 0, subject.shading);
    const auto draw_values = [&](std::size_t) {
        target.begin();
        value_painter.upload(subject.vertices.positions, subject.values, subject.surface());
        value_painter.draw(subject.view);
        gl::Finish();
    };
    bench.draw_values = timeRuns(runs, draw_values).median;
    if (hasVisibility(*subject.asset))
        benchModelPainter(subject, target, value_painter, context->software, runs, bench);
    return bench;
}

}  // namespace

BenchResult benchAsset(const RenderOptions& asked, const AssetView& asset, int runs, int threads,
                       const std::vector<int>& characters) {
    refuseForTransfer(asset, {.crowd = !characters.empty()});
    RenderOptions options = asked;
    options.channel = asset.materials.empty() || asset.lights.empty() ? Channel::kAmbient : Channel::kShaded;
    options.suns = SunChoice::kOff;
    Subject subject;
    subject.asset = &asset;
    subject.channel = options.channel;
    subject.shot = resolveShot(options, asset, nullptr);
    subject.threads = threads > 0 ? threads : hardwareThreads();
    std::optional<ShadingSet> shading;
    if (subject.shot.shaded) shading.emplace(shadingOf(subject.shot));
    subject.shading = shading ? &*shading : nullptr;
    Evaluator evaluator(asset);
    evaluateFrame(subject.shot, VisibilitySource::kModel, evaluator, subject.threads, subject.vertices);
    subject.view = makePictureView(options, asset, subject.vertices.positions);
    evaluateValues(subject, evaluator, subject.shot.frame);

    BenchResult result;
    result.vertices = asset.mesh.positions.size();
    result.triangles = asset.mesh.triangles.size() / 3;
    result.threads = subject.threads;
    if (shading) result.terms = shading->terms();
    if (subject.shot.shaded) result.suns = asset.lights[subject.shot.light].suns.size();
    result.cpu = benchCpu(subject.shot, subject.shading, subject.view.eye, runs, subject.threads);
    result.gl = benchGl(subject, options, runs);
    result.characters = benchCharacters(options, subject.shot, subject.shading, characters, runs, subject.threads);
    return result;
}

}  // namespace penumbra
