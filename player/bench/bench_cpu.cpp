#include "player/bench/bench_cpu.h"

#include <cmath>
#include <functional>
#include <string_view>

#include "formats/common/parallel_for.h"
#include "player/papers/transfer/transfer_model.h"
#include "runtime/shade/lambert_material.h"

namespace penumbra {

namespace {

constexpr const char* kClayStage = "shade, as clay";
// Larger than the last-level cache of any machine that this is likely to run on.
constexpr std::size_t kBeyondCaches = 128u << 20;
// Within a core's second-level cache, and beyond it.
constexpr std::size_t kSecondLevel = 256u << 10, kThirdLevel = 8u << 20;

// An asset whose parts are all of one Lambertian material, under the light that is on.
struct Clay {
    LambertMaterial material{{1, 1, 1}};
    AssetView asset;
    ShadingSet set;

    explicit Clay(const ShadingSet& shading) : asset(clayOf(shading.asset(), material)), set(asset, shading.choice()) {
        set.setLight(shading.light());
        set.setBounces(shading.bounces());
    }
    static AssetView clayOf(AssetView asset, const LambertMaterial& material) {
        asset.materials = {material.view};
        asset.slot_material.assign(asset.slot_material.size(), 0);
        asset.surface.reset();
        return asset;
    }
};

// The stages of a frame of one asset, each to be called on its own.
class Stages {
public:
    Stages(const Shot& shot, ShadingSet* shading, Vec3 eye, int threads)
        : asset_(shot.asset), shading_(shading), eye_(eye), threads_(threads), evaluator_(*shot.asset) {
        evaluateFrame(shot, VisibilitySource::kModel, evaluator_, threads, vertices_);
        if (shading) shadeFrame(*shading, vertices_, eye, threads, radiance_);
        if (shading && shading->showsSurface()) clay_.emplace(*shading);
    }
    void pose(std::size_t run) {
        const std::size_t frame = run % asset_->animation.frameCount();
        evaluator_.setFrame(frame);
    }
    void skin() { skinFrame(evaluator_, threads_, vertices_); }
    // The far parts of a composed asset; evaluate() has them in it.
    void far(int threads) {
        far_.resize(evaluator_.vertexCount() * kFarCoefficients);
        parallelFor(evaluator_.clusterCount(), threads, [&](std::size_t c) { evaluator_.evaluateFar(c, far_); });
    }
    void far() { far(threads_); }
    void evaluate(int threads) { evaluateCoefficients(evaluator_, threads, vertices_); }
    void evaluateFast(int threads) {
        evaluator_.setQuality(FarQuality::kFast);
        evaluate(threads);
        evaluator_.setQuality(FarQuality::kFull);
    }
    void evaluate() { evaluate(threads_); }
    void shade() {
        if (shading_ && !shadeTransfer(evaluator_, *shading_, threads_, radiance_))
            shadeFrame(*shading_, vertices_, eye_, threads_, radiance_);
    }
    // The same vertices as clay; only where the asset shows pictures.
    bool hasClay() const { return clay_.has_value(); }
    void shadeClay() { shadeFrame(clay_->set, vertices_, eye_, threads_, clay_radiance_); }
    std::optional<ChangingParameter> parameter() const {
        if (!shading_ || !shading_->hasMaterial(shading_->materialOfSlot()[0])) return std::nullopt;
        return changingParameter(asset_->materials[shading_->materialOfSlot()[0]]);
    }
    // Shades with another parameter than the last time.
    void shadeChanged(std::size_t run) {
        const ChangingParameter range = *parameter();
        shading_->setParameter(shading_->materialOfSlot()[0],
                               std::lerp(range.least, range.most, run % 2 == 0 ? 0.9 : 0.2));
        shade();
    }
    void emptyCaches() {
        swept_.resize(kBeyondCaches / sizeof(swept_[0]));
        for (int& number : swept_) ++number;
    }

private:
    const AssetView* asset_;
    ShadingSet* shading_;
    Vec3 eye_;
    int threads_;
    Evaluator evaluator_;
    FrameVertices vertices_;
    std::vector<Vec3> radiance_, clay_radiance_;
    std::optional<Clay> clay_;
    std::vector<float> far_;
    std::vector<int> swept_;
};

void measureRange(const AssetView& asset, CpuBench& bench) {
    Evaluator evaluator(asset);
    const std::size_t frames = asset.animation.frameCount();
    for (std::size_t f = 0; f < frames; ++f) {
        evaluator.setFrame(f);
        bench.out_of_range_mean += evaluator.outOfRange() / double(frames);
        bench.out_of_range_max = std::max(bench.out_of_range_max, evaluator.outOfRange());
    }
}

// A stage to time: what comes before each run and is not timed, and the run.
struct TimedStage {
    CpuStage stage;
    std::function<void(std::size_t)> prepare, body;
    int runs;
};

std::vector<TimedStage> stagesOf(const AssetView& asset, const ShadingSet* shading, int runs, int threads,
                                 Stages& stages) {
    const auto nothing = [](std::size_t) {};
    const StageWork evaluate = evaluateWork(asset);
    std::vector<TimedStage> timed = {
        {{"pose", {}, poseWork(asset), 1}, nothing, [&](std::size_t run) { stages.pose(run); }, runs},
        {{"skin", {}, skinWork(asset), threads}, nothing, [&](std::size_t) { stages.skin(); }, runs},
        {{"evaluate, 1 thread", {}, evaluate, 1}, nothing, [&](std::size_t) { stages.evaluate(1); }, runs},
        {{"evaluate", {}, evaluate, threads}, nothing, [&](std::size_t) { stages.evaluate(); }, runs},
        {{"evaluate, cold", {}, evaluate, threads, kBeyondCaches},
         [&](std::size_t) { stages.emptyCaches(); },
         [&](std::size_t) { stages.evaluate(); },
         std::min(runs, 10)}};
    if (asset.model.composition) {
        const StageWork far = farWork(asset);
        const std::vector<TimedStage> far_stages = {
            {{"far, 1 thread", {}, far, 1}, nothing, [&](std::size_t) { stages.far(1); }, runs},
            {{"far", {}, far, threads}, nothing, [&](std::size_t) { stages.far(); }, runs},
            {{"evaluate, fast", {}, {}, threads}, nothing, [&](std::size_t) { stages.evaluateFast(threads); }, runs}};
        timed.insert(timed.begin() + 2, far_stages.begin(), far_stages.end());
    }
    if (stages.parameter())
        timed.push_back({{"shade, changed lobe", {}, {}, threads},
                         nothing,
                         [&](std::size_t run) { stages.shadeChanged(run); },
                         runs});
    if (stages.hasClay())
        timed.push_back({{kClayStage, {}, {}, threads}, nothing, [&](std::size_t) { stages.shadeClay(); }, runs});
    if (shading) {
        const StageWork work = shading->showsSurface() ? StageWork() : shadeWork(*shading);
        timed.push_back({{"shade", {}, work, threads}, nothing, [&](std::size_t) { stages.shade(); }, runs});
    }
    return timed;
}

// Times in several rounds over all stages, because a processor that others use too is at times a fifth slower for a
// while.
void timeStages(const AssetView& asset, const ShadingSet* shading, int runs, int threads, Stages& stages,
                CpuBench& bench) {
    constexpr int kRounds = 5;
    const std::vector<TimedStage> timed = stagesOf(asset, shading, runs, threads, stages);
    std::vector<std::vector<double>> times(timed.size());
    for (int round = 0; round < kRounds; ++round)
        for (std::size_t s = 0; s < timed.size(); ++s)
            collectRuns((timed[s].runs + kRounds - 1) / kRounds, timed[s].prepare, timed[s].body, times[s]);
    for (std::size_t s = 0; s < timed.size(); ++s) {
        bench.stages.push_back(timed[s].stage);
        bench.stages.back().time = summaryOf(times[s]);
        if (timed[s].stage.name == std::string_view(kClayStage)) bench.shade_clay = bench.stages.back().time;
    }
    if (shading) bench.shade = bench.stages.back().time;
}

// Compares each stage with a bandwidth that was measured on a working set of its own size, so in whichever cache it
// lives.
void compareWithRoof(CpuBench& bench, int threads) {
    std::vector<std::size_t> of_one = {kSecondLevel, kThirdLevel, kBeyondCaches};
    std::vector<std::size_t> of_all = {kSecondLevel * std::size_t(threads), kThirdLevel, kBeyondCaches};
    for (CpuStage& stage : bench.stages) {
        if (!stage.counted()) continue;
        if (stage.working_set == 0) stage.working_set = stage.work.bytes();
        (stage.threads == 1 ? of_one : of_all).push_back(stage.working_set);
    }
    bench.one_thread = measureRoofline(1, of_one);
    bench.all_threads = measureRoofline(threads, of_all);
    for (CpuStage& stage : bench.stages) {
        if (!stage.counted()) continue;
        const Roofline& roofline = stage.threads == 1 ? bench.one_thread : bench.all_threads;
        const auto memory = std::find_if(roofline.memory.begin(), roofline.memory.end(),
                                         [&](const Bandwidth& b) { return b.bytes == stage.working_set; });
        stage.roof = attainable(roofline, *memory, stage.intensity());
        stage.memory_bound = stage.roof < roofline.peak;
    }
}

}  // namespace

// Switches to the next material that can be on for one of the parts, to the next light that can be on, and to another
// rotation.
void switchAll(ShadingSet& set, std::size_t run) {
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

CpuBench benchCpu(const Shot& shot, ShadingSet* shading, Vec3 eye, int runs, int threads) {
    if (threads <= 0) threads = hardwareThreads();
    CpuBench bench;
    measureRange(*shot.asset, bench);
    Stages stages(shot, shading, eye, threads);
    timeStages(*shot.asset, shading, runs, threads, stages, bench);
    compareWithRoof(bench, threads);
    bench.pose_evaluate = timeRuns(runs, [&](std::size_t run) {
        stages.pose(run);
        stages.evaluate();
    });
    bench.pose_skin_evaluate = timeRuns(runs, [&](std::size_t run) {
        stages.pose(run);
        stages.skin();
        stages.evaluate();
    });
    const bool lit = shading && !hasVisibility(*shot.asset);  // shading needs no transfer
    bench.frame = timeRuns(runs, [&](std::size_t run) {
        stages.pose(run);
        stages.skin();
        if (!lit) stages.evaluate();
        stages.shade();
    });
    if (shading) bench.switching = timeSwitching(*shading, runs, [&](std::size_t) { stages.shade(); });
    return bench;
}

}  // namespace penumbra
