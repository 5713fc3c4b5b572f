#include "player/bench/scene_gpu_cost.h"

#include <array>
#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "player/bench/stage_time.h"
#include "player/gl/gpu_timer.h"
#include "player/render/scene_on_gpu.h"
#include "player/render/sunlight_of_scene.h"

namespace penumbra {

namespace {

constexpr int kWarmUpFrames = 5;  // the first one compiles, and GpuTimer is 4 behind

// Measures a step of many frames.
struct StepTimes {
    GpuTimer timer;
    std::vector<double> until_done, gpu;

    template <class Body>
    void run(bool counts, const Body& body) {
        const Clock::time_point start = Clock::now();
        timer.begin();
        body();
        timer.end();
        gl::Finish();
        if (!counts) return;
        until_done.push_back(millisecondsSince(start));
        gpu.push_back(timer.milliseconds());
    }
};

nlohmann::ordered_json figuresOf(const SceneGpuSteps& steps) {
    return {
        {"evaluate_ms", steps.evaluate}, {"maps_ms", steps.maps}, {"draw_ms", steps.draw}, {"frame_ms", steps.all()}};
}

}  // namespace

std::optional<SceneGpuCost> measureSceneGpuCost(const PosedScene& scene, const RenderOptions& options, int threads,
                                                int runs) try {
    if (!fitsGpu(scene, options)) return std::nullopt;
    const OffscreenTarget target(options.width, options.height, options.samples, GL_RGBA8);
    SceneOnGpu frames(scene, options, threads);
    std::optional<Sunlight> suns = sunlightOf(scene, frames, options.sun_map);
    std::array<StepTimes, 3> steps;
    for (int run = -kWarmUpFrames; run < runs; ++run) {
        throwIfInterrupted();
        gl::Finish();
        steps[0].run(run >= 0, [&] { frames.evaluate(); });
        steps[1].run(run >= 0, [&] {
            if (suns) suns->shine(frames.suns(), frames.sunCasters());
        });
        steps[2].run(run >= 0, [&] {
            target.begin();
            frames.draw(frames.view(), suns ? &*suns : nullptr);
        });
    }
    const auto medians = [&](std::vector<double> StepTimes::*times) {
        return SceneGpuSteps{median(steps[0].*times), median(steps[1].*times), median(steps[2].*times)};
    };
    return SceneGpuCost{medians(&StepTimes::until_done), medians(&StepTimes::gpu)};
} catch (const Unsupported&) {
    return std::nullopt;
}

nlohmann::ordered_json figuresOf(const SceneGpuCost& cost) {
    nlohmann::ordered_json json = figuresOf(cost.until_done);
    json["gpu"] = figuresOf(cost.gpu);
    return json;
}

}  // namespace penumbra
