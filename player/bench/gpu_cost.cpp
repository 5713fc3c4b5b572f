#include "player/bench/gpu_cost.h"

#include "player/bench/stage_time.h"
#include "player/gl/gpu_timer.h"

namespace penumbra {

constexpr int kWarmUp = 5;  // frames: the first one compiles, and GpuTimer is 4 behind

GpuCost measureGpuCost(const std::shared_ptr<GlAsset>& asset, Channel channel,
                       std::span<const PosedCharacter> characters, const FrameView& view, const OffscreenTarget& target,
                       bool software, int runs) {
    ModelPainter painter(asset, characters.size());
    GpuTimer evaluate_timer, draw_timer;
    std::vector<double> evaluate, draw, gpu_evaluate, gpu_draw;
    for (int run = -kWarmUp; run < runs; ++run) {
        target.begin();
        gl::Finish();
        const Clock::time_point start = Clock::now();
        evaluate_timer.begin();
        painter.evaluate(channel, characters, view.eye);
        evaluate_timer.end();
        gl::Finish();
        const Clock::time_point evaluated = Clock::now();
        draw_timer.begin();
        painter.draw(view);
        draw_timer.end();
        gl::Finish();
        if (run < 0) continue;
        evaluate.push_back(std::chrono::duration<double, std::milli>(evaluated - start).count());
        draw.push_back(millisecondsSince(evaluated));
        gpu_evaluate.push_back(evaluate_timer.milliseconds());
        gpu_draw.push_back(draw_timer.milliseconds());
    }
    GpuCost cost;
    cost.characters = characters.size();
    cost.evaluate = median(evaluate);
    cost.draw = median(draw);
    if (!software) cost.gpu_evaluate = median(gpu_evaluate), cost.gpu_draw = median(gpu_draw);
    cost.bytes_shared = asset->bytes();
    cost.bytes_each = painter.bytes() / characters.size();
    cost.bytes_uploaded = asset->pose().size * 4 * sizeof(float);
    return cost;
}

}  // namespace penumbra
