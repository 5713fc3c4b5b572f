#include "player/bench/bench_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "player/bench/scene_drawing.h"
#include "player/scene/cast_on.h"

namespace penumbra {

namespace {

constexpr double kCopySpacing = 2;  // metres

std::size_t columnsOf(int count) { return std::size_t(std::ceil(std::sqrt(double(count)))); }

SceneDescription copiesOf(const SceneDescription& scene, int count) {
    if (scene.characters.empty()) throw InvalidInput(scene.at + ": has no characters, whose cost could be measured");
    SceneDescription out;
    out.light = scene.light;
    out.camera = scene.camera;
    if (out.light.asset.empty()) out.light.asset = scene.characters.front().asset;
    const std::size_t columns = columnsOf(count);
    const double middle = 0.5 * double(columns - 1);
    for (std::size_t i = 0; i < std::size_t(count); ++i) {
        SceneCharacter& copy = out.characters.emplace_back(scene.characters.front());
        copy.position = toFloat(Vec3d{double(i % columns) - middle, 0, double(i / columns) - middle} * kCopySpacing) +
                        Vec3{0, copy.position.y, 0};
        copy.yaw = 40 * double(i);
    }
    SceneGround& ground = out.ground.emplace(scene.ground.value_or(SceneGround()));
    const double size = ground.size + kCopySpacing * double(columns - 1);
    ground.resolution = int(std::min<double>(kMaxGroundResolution, std::round(ground.resolution * size / ground.size)));
    ground.size = size;
    ground.center = {};
    return out;
}

template <class Body>
void timeThreads(int runs, int threads, CastCost& cost, const Body& body) {
    cost.one_thread = timeRuns(runs, [&](std::size_t) { body(1); }).median;
    cost.all_threads = threads == 1 ? cost.one_thread : timeRuns(runs, [&](std::size_t) { body(threads); }).median;
}

double timePose(const PosedScene& scene, int runs) {
    const SceneMember* caster = nullptr;
    for (const std::unique_ptr<SceneMember>& member : scene.members())
        if (!caster && member->caster != kNobody) caster = member.get();
    if (!caster) return 0;
    const Evaluator* const alone = &caster->evaluator;
    const CasterKind kind = *casterKindOf(*caster->file, *alone);
    CastShadow cast({&alone, 1}, {&kind, 1});
    return timeRuns(runs, [&](std::size_t) { cast.pose(0, alone->bones(), caster->to_scene); }).median;
}

void timeMembers(const PosedScene& scene, const SceneFrames& frames, int runs, int threads, CastCost& cost) {
    for (std::size_t m = 0; m < frames.members().size(); ++m) {
        const std::size_t vertices = frames.members()[m].positions.size();
        cost.receivers += vertices;
        cost.pairs += vertices * (scene.cast().casterCount() - (scene.members()[m]->caster == kNobody ? 0 : 1));
    }
    std::vector<float> mirrored;
    timeThreads(runs, threads, cost, [&](int some) {
        for (std::size_t m = 0; m < frames.members().size(); ++m) {
            const FrameVertices& vertices = frames.members()[m];
            castOnCharacter(scene.cast(), {.except = scene.members()[m]->caster}, scene.members()[m]->evaluator,
                            {vertices.positions, vertices.normals, vertices.tangents}, some, mirrored);
        }
    });
}

// A field that moves is another one in every run; one that is still is looked at anew.
FieldCost timeField(PosedScene& scene, const SceneFrames& frames, int runs, int threads) {
    SceneField& field = *scene.field();
    FieldCost cost;
    cost.receivers = field.receiverCount();
    FrameVertices points = frames.field();
    const auto all = [&](int some) {
        const Clock::time_point start = Clock::now();
        std::vector<double> taken;
        for (int run = 0; run < runs; ++run) {
            throwIfInterrupted();
            field.pose(0.04 * (run + 1));
            field.lookAgain();
            const Clock::time_point from = Clock::now();
            field.evaluate(some, points);
            taken.push_back(millisecondsSince(from));
        }
        cost.frame = millisecondsSince(start) / runs;
        return median(taken);
    };
    cost.one_thread = all(1);
    cost.all_threads = threads == 1 ? cost.one_thread : all(threads);
    field.pose({});
    return cost;
}

// Casters whose reach a member's vertices are in, mean over the members. Who is in reach of few of them counts whole.
double meanReached(const PosedScene& scene, const SceneFrames& frames) {
    std::size_t reached = 0;
    std::vector<float> mirrored;
    for (std::size_t m = 0; m < frames.members().size(); ++m) {
        const FrameVertices& vertices = frames.members()[m];
        const CasterSphere around = sphereAround(vertices.positions);
        for (std::size_t c = 0; c < scene.cast().casterCount(); ++c)
            reached += c != scene.members()[m]->caster && scene.cast().reaches(c, around) ? 1 : 0;
    }
    return double(reached) / double(frames.members().size());
}

AnchorError anchorError(const PosedScene& scene, const SceneFrames& frames, int threads) {
    constexpr std::size_t kMaxMembers = 4;
    std::array<float, kFarCoefficients> weights;
    ambientWeights(Convention{BelowHorizon::kMirrored, kFieldOrder}, weights);
    AnchorError error;
    std::vector<float> anchored, each;
    std::size_t count = 0;
    for (std::size_t m = 0; m < std::min(kMaxMembers, frames.members().size()); ++m) {
        const FrameVertices& vertices = frames.members()[m];
        const CastReceivers receivers{vertices.positions, vertices.normals, vertices.tangents};
        const CasterChoice others{.except = scene.members()[m]->caster};
        castOnCharacter(scene.cast(), others, scene.members()[m]->evaluator, receivers, threads, anchored);
        castOn(scene.cast(), others, receivers, threads, each);
        for (std::size_t first = 0; first < each.size(); first += kFarCoefficients, ++count) {
            double e = 0, off = 0;
            for (std::size_t i = 0; i < kFarCoefficients; ++i) {
                e += double(weights[i]) * double(each[first + i]);
                off += double(weights[i]) * (double(anchored[first + i]) - double(each[first + i]));
            }
            error.rms += off * off;
            if (!(std::abs(off) <= error.largest)) error.largest = std::abs(off);  // NaN, too
            error.hidden += 1 - e;
        }
    }
    error.rms = std::sqrt(error.rms / double(count));
    error.hidden /= double(count);
    return error;
}

// All of a frame; without a drawing as far as it can be done.
void runFrame(PosedScene& scene, SceneFrames& frames, SceneDrawing* drawing) {
    scene.pose({});
    frames.evaluateMembers();
    frames.evaluateGround();
    frames.shade();
    if (!drawing) return;
    drawing->drawMaps();
    drawing->drawMeshes();
    drawing->read();
}

void timeFrame(PosedScene& scene, SceneFrames& frames, SceneDrawing* drawing, int runs, SceneCost& cost) {
    cost.pose_all = timeRuns(runs, [&](std::size_t) { scene.pose({}); }).median;
    cost.evaluate_members = timeRuns(runs, [&](std::size_t) { frames.evaluateMembers(); }).median;
    cost.shade = timeRuns(runs, [&](std::size_t) { frames.shade(); }).median;
    if (drawing)
        cost.draw = timeRuns(runs, [&](std::size_t) {
                        drawing->drawMaps();
                        drawing->drawMeshes();
                        drawing->read();
                    }).median;
    cost.frame = timeRuns(runs, [&](std::size_t) { runFrame(scene, frames, drawing); });
}

// Runs both in turns, because other programs run beside us and would slow one of two series.
template <class Suns, class Plain>
WithSuns timeBoth(int runs, const Suns& suns, const Plain& plain) {
    std::vector<double> with, without;
    for (int run = -1; run < runs; ++run) {
        throwIfInterrupted();
        const Clock::time_point start = Clock::now();
        suns();
        const double between = millisecondsSince(start);
        plain();
        const double end = millisecondsSince(start);
        if (run < 0) continue;  // drivers compile in the first draw
        with.push_back(between);
        without.push_back(end - between);
    }
    return {median(with), median(without)};
}

SunCost timeSuns(PosedScene& scene, SceneFrames& frames, SceneDrawing& drawing, const RenderOptions& options, int runs,
                 int threads) {
    RenderOptions off = options;
    off.suns = SunChoice::kOff;
    SceneFrames plain_frames(scene, off, threads);
    plain_frames.evaluateMembers();
    plain_frames.evaluateGround();
    plain_frames.frameCamera();
    plain_frames.shade();
    SceneDrawing plain_drawing(scene, plain_frames, off);
    SunCost cost;
    cost.count = frames.suns().size();
    cost.map = timeRuns(runs, [&](std::size_t) {
                   drawing.drawMaps();
                   gl::Finish();
               }).median;
    cost.shade = timeBoth(
        runs, [&] { frames.shade(); }, [&] { plain_frames.shade(); });
    const auto draw = [](SceneDrawing& one) {
        one.drawMeshes();
        gl::Finish();
    };
    cost.draw = timeBoth(
        runs, [&] { draw(drawing); }, [&] { draw(plain_drawing); });
    cost.frame = timeBoth(
        runs, [&] { runFrame(scene, frames, &drawing); }, [&] { runFrame(scene, plain_frames, &plain_drawing); });
    return cost;
}

SceneCost costOf(const RenderOptions& options, const SceneDescription& description, const GlContext* context, int runs,
                 int threads) {
    PosedScene scene(description);
    SceneFrames frames(scene, options, threads);
    frames.evaluateMembers();
    frames.evaluateGround();
    frames.frameCamera();
    frames.shade();
    SceneCost cost;
    cost.members = scene.members().size();
    cost.casters = scene.cast().casterCount();
    runs = std::max(1, runs / int(cost.members));
    cost.pose = timePose(scene, std::max(10, runs));
    timeMembers(scene, frames, runs, threads, cost.members_cast);
    cost.anchors = anchorError(scene, frames, threads);
    cost.reached = meanReached(scene, frames);
    if (scene.field()) {
        cost.ground_vertices = frames.field().positions.size();
        cost.ground_cast.receivers = cost.ground_vertices;
        cost.ground_cast.pairs = cost.ground_cast.receivers * cost.casters;
        timeThreads(runs, threads, cost.ground_cast, [&](int some) {
            FrameVertices points = frames.field();
            scene.field()->castOn(scene.cast(), some, points);
        });
        cost.field = timeField(scene, frames, runs, threads);
    } else if (description.ground) {
        cost.ground_vertices = frames.ground().positions.size();
        cost.ground_cast.receivers = frames.ground().evaluated;
        cost.ground_cast.pairs = cost.ground_cast.receivers * cost.casters;
        GroundVertices ground = frames.ground();
        timeThreads(runs, threads, cost.ground_cast, [&](int some) { castOnGround(scene.cast(), some, ground); });
    }
    std::optional<SceneDrawing> drawing;
    if (context) drawing.emplace(scene, frames, options);
    timeFrame(scene, frames, drawing ? &*drawing : nullptr, runs, cost);
    if (context && !frames.suns().empty()) cost.suns = timeSuns(scene, frames, *drawing, options, runs, threads);
    if (context && !context->software) cost.gpu = measureSceneGpuCost(scene, options, threads, runs);
    return cost;
}

// The scene, then its copies.
std::vector<const SceneCost*> allOf(const SceneBench& bench) {
    std::vector<const SceneCost*> all = {&bench.scene};
    for (const SceneCost& cost : bench.copies) all.push_back(&cost);
    return all;
}

// Returns the first word of a row.
std::string nameOf(const SceneBench& bench, const SceneCost& cost) {
    return &cost == &bench.scene ? "scene" : std::to_string(cost.members);
}

void printCast(const char* name, const CastCost& cost, std::size_t all) {
    std::printf("%-10s %10zu %10zu %13.3f %12.3f", name, all, cost.receivers, cost.one_thread, cost.all_threads);
    if (cost.pairs > 0)
        std::printf(" %10.1f\n", cost.nanosecondsOfPair());
    else
        std::printf(" %10s\n", "-");
}

void printCasts(const SceneBench& bench) {
    const auto header = [&](const char* what) {
        std::printf("%-10s %10s %10s %13s %9d th. %10s\n", what, "vertices", "evaluated", "ms, 1 thread", bench.threads,
                    "ns a pair");
    };
    header("members");
    for (const SceneCost* cost : allOf(bench))
        printCast(nameOf(bench, *cost).c_str(), cost->members_cast, cost->members_cast.receivers);
    header("ground");
    for (const SceneCost* cost : allOf(bench))
        if (cost->ground_vertices > 0)
            printCast(nameOf(bench, *cost).c_str(), cost->ground_cast, cost->ground_vertices);
    std::printf("a pair is a vertex and a caster, in reach or not; members are past everyone but themselves\n");
    std::printf("%-10s %10s %10s %13s %12s %10s\n", "anchors", "in reach", "ms a pair", "E hidden", "off, rms",
                "largest");
    for (const SceneCost* cost : allOf(bench))
        std::printf("%-10s %10.1f %10.3f %13.4f %12.5f %10.4f\n", nameOf(bench, *cost).c_str(), cost->reached,
                    cost->members_cast.one_thread / std::max(1.0, cost->reached * double(cost->members)),
                    cost->anchors.hidden, cost->anchors.rms, cost->anchors.largest);
    std::printf("in reach are casters of a member; off is E against that of every vertex for itself\n");
}

void printFrames(const SceneBench& bench) {
    std::printf("%-10s %9s %9s %9s %9s %9s %9s %9s %8s\n", "frame, ms", "members", "pose", "evaluate", "ground",
                "shade", "draw", "all, ms", "Hz");
    for (const SceneCost* cost : allOf(bench)) {
        char draw[32] = "-";
        if (cost->draw) std::snprintf(draw, sizeof draw, "%.3f", *cost->draw);
        std::printf("%-10s %9zu %9.3f %9.3f %9.3f %9.3f %9s %9.3f %8.1f\n", nameOf(bench, *cost).c_str(), cost->members,
                    cost->pose_all, cost->evaluate_members, cost->ground_cast.all_threads, cost->shade, draw,
                    cost->frame.median, 1000 / cost->frame.median);
    }
}

void printSuns(const SceneBench& bench) {
    bool header = false;
    for (const SceneCost* cost : allOf(bench)) {
        if (!cost->suns) continue;
        if (!header)
            std::printf("%-10s %9s %9s | %9s %9s %6s | %9s %9s %6s | %9s %9s %6s\n", "suns, ms", "suns", "maps",
                        "shade", "without", "ratio", "draw", "without", "ratio", "all", "without", "ratio");
        header = true;
        std::printf("%-10s %9zu %9.3f", nameOf(bench, *cost).c_str(), cost->suns->count, cost->suns->map);
        for (const WithSuns& time : {cost->suns->shade, cost->suns->draw, cost->suns->frame})
            std::printf(" | %9.3f %9.3f %6.3f", time.with, time.without, time.ratio());
        std::printf("\n");
    }
    if (header) std::printf("without suns all of the light is SH; draw is upload and drawing, without the maps\n");
}

void printGpuRow(const char* name, const char* what, const SceneGpuSteps& steps) {
    std::printf("%-10s %-11s %9.3f %9.3f %9.3f %9.3f %8.1f\n", name, what, steps.evaluate, steps.maps, steps.draw,
                steps.all(), 1000 / steps.all());
}

void printGpu(const SceneBench& bench) {
    if (!bench.scene.gpu) return;
    std::printf("%-10s %-11s %9s %9s %9s %9s %8s\n", "GLSL path", "ms", "evaluate", "maps", "draw", "all", "Hz");
    for (const SceneCost* cost : allOf(bench)) {
        if (!cost->gpu) continue;
        const std::string name = nameOf(bench, *cost);
        printGpuRow(name.c_str(), "until done", cost->gpu->until_done);
        printGpuRow(name.c_str(), "GPU itself", cost->gpu->gpu);
    }
}

nlohmann::ordered_json figuresOf(const WithSuns& time) {
    return {{"with_ms", time.with}, {"without_ms", time.without}, {"ratio", time.ratio()}};
}

nlohmann::ordered_json figuresOf(const SunCost& cost) {
    return {{"count", cost.count},
            {"maps_ms", cost.map},
            {"shade", figuresOf(cost.shade)},
            {"draw", figuresOf(cost.draw)},
            {"frame", figuresOf(cost.frame)}};
}

nlohmann::ordered_json figuresOf(const CastCost& cost) {
    nlohmann::ordered_json out = {{"evaluated", cost.receivers},
                                  {"pairs", cost.pairs},
                                  {"one_thread_ms", cost.one_thread},
                                  {"all_threads_ms", cost.all_threads},
                                  {"pair_ns", nullptr}};
    if (cost.pairs > 0) out["pair_ns"] = cost.nanosecondsOfPair();
    return out;
}

nlohmann::ordered_json figuresOf(const SceneCost& cost) {
    return {{"members", cost.members},
            {"casters", cost.casters},
            {"pose_caster_ms", cost.pose},
            {"members_cast", figuresOf(cost.members_cast)},
            {"in_reach", cost.reached},
            {"anchors_rms", cost.anchors.rms},
            {"anchors_largest", cost.anchors.largest},
            {"ground_vertices", cost.ground_vertices},
            {"ground", figuresOf(cost.ground_cast)},
            {"field", cost.field ? nlohmann::ordered_json{{"receivers", cost.field->receivers},
                                                          {"one_thread_ms", cost.field->one_thread},
                                                          {"all_threads_ms", cost.field->all_threads},
                                                          {"with_heights_ms", cost.field->frame}}
                                 : nlohmann::ordered_json()},
            {"pose_ms", cost.pose_all},
            {"evaluate_ms", cost.evaluate_members},
            {"shade_ms", cost.shade},
            {"draw_ms", cost.draw ? nlohmann::ordered_json(*cost.draw) : nlohmann::ordered_json()},
            {"frame_ms", cost.frame.median},
            {"frame_best_ms", cost.frame.best},
            {"hz", 1000 / cost.frame.median},
            {"suns", cost.suns ? figuresOf(*cost.suns) : nlohmann::ordered_json()},
            {"glsl_path", cost.gpu ? figuresOf(*cost.gpu) : nlohmann::ordered_json()}};
}

}  // namespace

SceneBench benchScene(const RenderOptions& asked, const SceneDescription& scene, int runs, int threads,
                      std::vector<int> counts) {
    if (!counts.empty() && scene.characters.empty())
        throw BadOption("characters", "the scene has no character to copy");
    SceneBench bench;
    bench.threads = threads > 0 ? threads : hardwareThreads();
    RenderOptions options = asked;
    options.channel = PosedScene(scene).light() ? Channel::kShaded : Channel::kAmbient;
    std::unique_ptr<GlContext> context;
    try {
        context = createGlContext(options.backend);
        bench.context = context->description;
    } catch (const Unsupported& error) {
        bench.context = error.what();
    }
    std::sort(counts.begin(), counts.end());
    bench.scene = costOf(options, scene, context.get(), runs, bench.threads);
    for (const int count : counts)
        bench.copies.push_back(costOf(options, copiesOf(scene, count), context.get(), runs, bench.threads));
    return bench;
}

void printScene(const SceneBench& bench) {
    std::printf("%zu characters and props, %zu of which cast, %d threads; %s\n", bench.scene.members,
                bench.scene.casters, bench.threads, bench.context.c_str());
    if (bench.scene.casters > 0) std::printf("%-32s %8.3f ms\n", "pose of one caster", bench.scene.pose);
    printCasts(bench);
    if (const std::optional<FieldCost>& field = bench.scene.field)
        std::printf(
            "%-10s %10zu points, horizons at %zu; visibility %.3f ms, 1 thread, %.3f ms, %d threads; with new "
            "heights %.3f ms\n",
            "field", bench.scene.ground_vertices, field->receivers, field->one_thread, field->all_threads,
            bench.threads, field->frame);
    printFrames(bench);
    printSuns(bench);
    printGpu(bench);
}

nlohmann::ordered_json figuresOf(const SceneBench& bench) {
    nlohmann::ordered_json copies = nlohmann::ordered_json::array();
    for (const SceneCost& cost : bench.copies) copies.push_back(figuresOf(cost));
    return {
        {"threads", bench.threads}, {"context", bench.context}, {"scene", figuresOf(bench.scene)}, {"copies", copies}};
}

}  // namespace penumbra
