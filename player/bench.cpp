#include "player/bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "formats/write_file.h"
#include "player/draw_frame.h"
#include "player/frame_values.h"
#include "player/offscreen_target.h"
#include "player/picture_view.h"

namespace penumbra {

using Clock = std::chrono::steady_clock;

static double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

static double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// The median of the times that `body(run)` takes; one run before the first that counts.
template <class Body>
static double time(int runs, const Body& body) {
    std::vector<double> times;
    for (int run = -1; run < runs; ++run) {
        throwIfInterrupted();
        const Clock::time_point start = Clock::now();
        body(std::size_t(run + 1));
        if (run >= 0) times.push_back(millisecondsSince(start));
    }
    return median(std::move(times));
}

// The next material that can be on for one of the parts, the next light that can be, and another rotation.
static void switchAll(ShadingSet& set, std::size_t run) {
    const AssetView& asset = set.asset();
    const std::size_t slot = run % set.slotCount();
    std::size_t material = set.materialOfSlot()[slot], light = set.light();
    do material = (material + 1) % asset.materials.size();
    while (!set.hasMaterial(material));
    do light = (light + 1) % asset.lights.size();
    while (!set.hasLight(light));
    set.setMaterial(slot, material);
    set.setLight(light);
    const float turn = 0.1f * float(run), c = std::cos(turn), s = std::sin(turn);
    set.setLightRotation({{c, 0, s, 0, 1, 0, -s, 0, c}});
}

// `frame(run)` draws one.
template <class Frame>
static BenchResult::Switching timeSwitching(ShadingSet& set, int runs, const Frame& frame) {
    std::vector<double> switched, steady;
    for (int run = -1; run < runs; ++run) {
        throwIfInterrupted();
        for (const bool change : {true, false}) {
            const Clock::time_point start = Clock::now();
            if (change) switchAll(set, std::size_t(run + 1));
            frame(std::size_t(run + 1));
            if (run >= 0) (change ? switched : steady).push_back(millisecondsSince(start));
        }
    }
    return {median(switched), *std::max_element(switched.begin(), switched.end()), median(steady),
            *std::max_element(steady.begin(), steady.end())};
}

static std::size_t bytesRead(const ModelView& model) {
    std::size_t bytes = 0;
    for (const ClusterView& cluster : model.clusters)
        for (const NumbersView& numbers : {cluster.mean, cluster.basis})
            bytes += numbers.count * bytesPerNumber(numbers.precision);
    return bytes;
}

static void measureRange(Evaluator& evaluator, const AnimationView& animation, BenchResult& result) {
    const std::size_t frames = animation.frameCount();
    for (std::size_t f = 0; f < frames; ++f) {
        evaluator.setPose(animation.bonesOf(f), animation.poseOf(f));
        result.out_of_range_mean += evaluator.outOfRange() / double(frames);
        result.out_of_range_max = std::max(result.out_of_range_max, evaluator.outOfRange());
    }
}

static void benchCpu(const Shot& shot, ShadingSet* shading, Evaluator& evaluator, const RenderOptions& options,
                     int runs, int threads, FrameVertices& vertices, std::vector<Vec3>& values, BenchResult& result) {
    const AssetView& asset = *shot.asset;
    const auto pose = [&](std::size_t run) {
        const std::size_t frame = run % asset.animation.frameCount();
        evaluator.setPose(asset.animation.bonesOf(frame), asset.animation.poseOf(frame));
    };
    evaluateFrame(shot, VisibilitySource::kModel, evaluator, threads, vertices);
    const Vec3 eye = makePictureView(options, asset, vertices.positions).eye;
    result.skin = time(runs, [&](std::size_t run) {
        pose(run);
        skinFrame(evaluator, threads, vertices);
    });
    result.evaluate = time(runs, [&](std::size_t) { evaluateNumbers(evaluator, threads, vertices); });
    values = channelValues(shot, options.channel, shading, vertices, {}, eye, threads);
    if (options.channel != Channel::kShaded) return;
    result.shade = time(runs, [&](std::size_t) { shadeFrame(*shading, vertices, eye, threads, values); });
    result.switch_cpu =
        timeSwitching(*shading, runs, [&](std::size_t) { shadeFrame(*shading, vertices, eye, threads, values); });
}

BenchResult benchAsset(const RenderOptions& asked, const AssetView& asset, int runs, int threads) {
    RenderOptions options = asked;
    options.channel = asset.materials.empty() || asset.lights.empty() ? Channel::kAmbient : Channel::kShaded;
    const Shot shot = resolveShot(options, asset, nullptr);
    BenchResult result;
    result.vertices = asset.mesh.positions.size();
    result.triangles = asset.mesh.triangles.size() / 3;
    result.bytes_read = bytesRead(asset.model);
    Evaluator evaluator(asset);
    FrameVertices vertices;
    std::vector<Vec3> values;
    measureRange(evaluator, asset.animation, result);
    std::optional<ShadingSet> shading;
    if (shot.shaded) shading.emplace(shadingOf(shot));
    ShadingSet* const shading_view = shading ? &*shading : nullptr;
    benchCpu(shot, shading_view, evaluator, options, runs, threads, vertices, values, result);

    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    result.gl = context->description;
    const OffscreenTarget target(options.width, options.height, options.samples);
    const FrameView view = makePictureView(options, asset, vertices.positions);
    const ValuePainter value_painter(asset.mesh.triangles, options.channel);
    result.draw_values = time(runs, [&](std::size_t) {
        target.begin();
        value_painter.draw(view, vertices.positions, values);
        gl::Finish();
    });
    const Clock::time_point start = Clock::now();
    ModelPainter model_painter(asset, options.channel, shading_view, /*numbers_given=*/false);
    const auto draw_model = [&](std::size_t run) {
        target.begin();
        model_painter.setPose(evaluator, asset.animation.bonesOf(run % asset.animation.frameCount()));
        model_painter.draw(view);
        gl::Finish();
    };
    draw_model(0);  // drivers compile at the first draw
    result.first_frame = millisecondsSince(start);
    result.draw_model = time(runs, draw_model);
    if (shading) result.switch_gl = timeSwitching(*shading, runs, draw_model);
    return result;
}

}  // namespace penumbra
