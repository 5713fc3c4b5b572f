#pragma once
// Measures what a frame of an asset costs on the CPU, stage by stage, and how near each stage comes to the machine's
// limits.
#include <optional>

#include "player/bench/roofline.h"
#include "player/bench/stage_time.h"
#include "player/bench/stage_work.h"
#include "player/frame/frame_values.h"

namespace penumbra {

struct CpuStage {
    const char* name = "";
    StageTime time;
    StageWork work;
    int threads = 1;
    std::size_t working_set = 0;  // bytes that every run reads again
    double roof = 0;              // GFLOP/s that can be attained
    bool memory_bound = false;    // true if memory is the lower of the two roofs
    double gflops() const { return work.flop / time.best * 1e-6; }
    double gigabytes() const { return double(work.bytes()) / time.best * 1e-6; }
    double intensity() const { return work.flop / double(work.bytes()); }
    double ofRoof() const { return gflops() / roof; }
    bool counted() const { return work.bytes() > 0; }  // else only its time is known
};

// Compares frames before which a part, its material, the light and its rotation change with the frames that follow
// without a change. The two take turns, so that both see the same work. A frame is shading alone on the CPU, and all
// of it on GL.
struct Switching {
    double switched = 0, switched_worst = 0, steady = 0, steady_worst = 0;
};

struct CpuBench {
    Roofline one_thread, all_threads;
    // The stages in their order are pose, skin, evaluate on one thread, evaluate on all threads, evaluate on all
    // threads with nothing of the asset in a cache, and shade (only if there are a material and a light).
    std::vector<CpuStage> stages;
    StageTime pose_evaluate, pose_skin_evaluate, shade, frame;  // shade: 0 without a material; frame: all stages
    StageTime shade_clay;  // the same vertices under one Lambertian material; 0 where no pictures are shown
    Switching switching;
    double out_of_range_mean = 0, out_of_range_max = 0;  // Evaluator::outOfRange() over the asset's frames
};

// Measures. Every run takes the next sampled frame of the asset. `shading` may be null.
CpuBench benchCpu(const Shot& shot, ShadingSet* shading, Vec3 eye, int runs, int threads);

// Switches materials and light. timeSwitching() calls it between draws by `frame(run)`; the GL side uses it too.
void switchAll(ShadingSet& set, std::size_t run);
template <class Frame>
Switching timeSwitching(ShadingSet& set, int runs, const Frame& frame) {
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

}  // namespace penumbra
