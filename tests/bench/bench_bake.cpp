// Bake throughput against bare Embree loops over the same rays in the same run: what skinning, scene building,
// accumulation and writing cost on top of ray tracing.
//   bench_bake [RIG...] [--rays N] [--threads N] [--runs N]
// Without a rig: $PENUMBRA_DATA/rigs/mh_male_cmu05.glb when that variable is set, and always a synthetic bumpy sphere.
#include <pmmintrin.h>
#include <sys/resource.h>
#include <unistd.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "bake/trace/embree.h"
#include "bake/trace/moments.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/common/parallel_for.h"

using namespace penumbra;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::size_t kBlock = 64;  // vertices of a task, as in the bake

struct Settings {
    int rays = 1024, threads = 0, runs = 5;
};

// A mesh in the ray tracer's frame, with the origins of its rays.
struct Case {
    std::string name;
    std::vector<Vec3> positions, normals, origins;
    std::vector<Triangle> triangles;
};

void finish(Case& c, const std::vector<Vec3>& model_positions, double diagonal) {
    const SceneScale scale = sceneScale(model_positions, diagonal);
    for (std::size_t v = 0; v < model_positions.size(); ++v) {
        c.positions.push_back(scale.apply(model_positions[v]));
        c.origins.push_back(c.positions.back() + c.normals[v] * 1e-4f);
    }
}

Case bumpySphere(int rings) {
    Case c{"sphere", {}, {}, {}, {}};
    const int columns = 2 * rings;
    std::vector<Vec3> points;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const double t = std::numbers::pi * (i + 0.5) / (rings + 1), p = 2 * std::numbers::pi * j / columns;
            const Vec3d d{std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p)};
            points.push_back(toFloat(d * (1 + 0.25 * std::sin(6 * d.x) * std::sin(5 * d.y) * std::sin(4 * d.z))));
        }
    const auto at = [&](int i, int j) { return std::uint32_t(i * columns + j % columns); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            c.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            c.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    c.normals = vertexNormals(c.triangles, points);
    finish(c, points, boxDiagonal(points));
    return c;
}

Case middleFrame(const BakePlan& plan, const std::string& name) {
    const std::size_t f = plan.header.frames.frameCount() / 2;
    const FrameList& frames = plan.header.frames;
    const SourcePose pose = poseSource(plan.source, plan.source_clip[frames.clip[f]], frames.time[f]);
    Case c{name, {}, {}, {}, plan.source.mesh().triangles};
    c.normals = pose.normals;
    finish(c, pose.positions, plan.rest_diagonal);
    return c;
}

struct Bare {
    RTCDevice device = rtcNewDevice("");
    RTCScene scene = rtcNewScene(device);
    explicit Bare(const Case& c) {
        RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::memcpy(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, c.positions.size()),
                    c.positions.data(), c.positions.size() * 12);
        std::memcpy(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, c.triangles.size()),
                    c.triangles.data(), c.triangles.size() * 12);
        rtcCommitGeometry(g);
        rtcAttachGeometry(scene, g);
        rtcReleaseGeometry(g);
        rtcCommitScene(scene);
    }
    ~Bare() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

float cosine(const DirectionPacket& d, std::size_t k, Vec3 n) { return d.x[k] * n.x + d.y[k] * n.y + d.z[k] * n.z; }

// Counts the rays that escape from vertices [begin, end).
using Loop = std::function<std::size_t(std::size_t begin, std::size_t end)>;

Loop packets(const Case& c, const Bare& bare, const RayDirections& directions, Packets order) {
    return [&c, &bare, &directions, order](std::size_t begin, std::size_t end) {
        RayQuery query(nullptr, order);
        RTCRay8 ray{};
        std::fill_n(ray.mask, 8, ~0u);
        std::size_t escaped = 0;
        for (std::size_t v = begin; v < end; ++v) {
            std::fill_n(ray.org_x, 8, c.origins[v].x);
            std::fill_n(ray.org_y, 8, c.origins[v].y);
            std::fill_n(ray.org_z, 8, c.origins[v].z);
            for (const DirectionPacket& d : directions.packets) {
                alignas(32) int valid[8];
                int any = 0;
                for (std::size_t k = 0; k < 8; ++k) any |= valid[k] = cosine(d, k, c.normals[v]) > 0 ? -1 : 0;
                if (!any) continue;
                std::copy_n(d.x.begin(), 8, ray.dir_x);
                std::copy_n(d.y.begin(), 8, ray.dir_y);
                std::copy_n(d.z.begin(), 8, ray.dir_z);
                std::fill_n(ray.tfar, 8, kInfinity);
                occluded8(valid, bare.scene, query, ray);
                for (std::size_t k = 0; k < 8; ++k) escaped += valid[k] && ray.tfar[k] > 0;
            }
        }
        return escaped;
    };
}

Loop singles(const Case& c, const Bare& bare, const RayDirections& directions) {
    return [&c, &bare, &directions](std::size_t begin, std::size_t end) {
        RayQuery query;
        std::size_t escaped = 0;
        for (std::size_t v = begin; v < end; ++v) {
            for (const DirectionPacket& d : directions.packets)
                for (std::size_t k = 0; k < 8; ++k) {
                    if (!(cosine(d, k, c.normals[v]) > 0)) continue;
                    const Vec3 o = c.origins[v];
                    RTCRay ray{o.x, o.y, o.z, 0, d.x[k], d.y[k], d.z[k], 0, kInfinity, ~0u, 0, 0};
                    occluded1(bare.scene, query, ray);
                    escaped += ray.tfar > 0;
                }
        }
        return escaped;
    };
}

double cpuSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

std::size_t runLoop(const Loop& loop, std::size_t vertices, int threads) {
    std::atomic<std::size_t> escaped = 0;
    parallelFor((vertices + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        const unsigned saved = _mm_getcsr();
        _mm_setcsr(saved | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON);
        escaped += loop(block * kBlock, std::min(vertices, (block + 1) * kBlock));
        _mm_setcsr(saved);
    });
    return escaped;
}

struct Row {
    std::string name;
    std::function<void()> run;
    double wall = kInfinity, cpu = kInfinity;  // seconds
};

// Interleaves the rows, so that a slow minute of the machine hits every row. The least time of all runs counts.
// Compare by CPU time where other work shares the cores.
void measure(std::vector<Row>& rows, int runs) {
    for (int run = 0; run < runs; ++run)
        for (Row& row : rows) {
            const double cpu_before = cpuSeconds();
            const auto start = std::chrono::steady_clock::now();
            row.run();
            row.wall =
                std::min(row.wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            row.cpu = std::min(row.cpu, cpuSeconds() - cpu_before);
        }
}

void printRows(const std::string& name, const std::vector<Row>& rows, double rays) {
    double bare_wall = kInfinity, bare_cpu = kInfinity;
    for (const Row& row : rows) {
        std::printf("%-20s %-32s %7.2f Mray/s %7.2f Mray/CPU s", name.c_str(), row.name.c_str(), rays / row.wall * 1e-6,
                    rays / row.cpu * 1e-6);
        if (row.name.starts_with("bake")) {
            std::printf("   ratio to the fastest bare loop %.3f (CPU %.3f)", bare_wall / row.wall, bare_cpu / row.cpu);
        } else {
            bare_wall = std::min(bare_wall, row.wall);
            bare_cpu = std::min(bare_cpu, row.cpu);
        }
        std::printf("\n");
    }
}

void benchKernel(const Case& c, const Settings& settings) {
    const RayDirections directions = makeRayDirections(settings.rays, 1, 5);
    const Bare bare(c);
    const std::size_t vertices = c.positions.size();
    const OcclusionScene scene(c.positions, c.triangles);
    const MomentTracer tracer{scene, directions, {}, 1e-4f};
    std::vector<float> b(vertices * 25);
    std::atomic<std::size_t> traced = 0;
    const auto bake = [&] {
        traced = 0;
        parallelFor((vertices + kBlock - 1) / kBlock, settings.threads, [&](std::size_t block) {
            const std::size_t begin = block * kBlock, size = std::min(kBlock, vertices - begin);
            traced +=
                traceMoments(tracer, std::span(c.positions).subspan(begin, size),
                             std::span(c.normals).subspan(begin, size), {std::span(b).subspan(begin * 25, size * 25)});
        });
    };
    std::size_t counts[3] = {};
    const auto row = [&](const char* name, Loop loop, std::size_t& count) {
        return Row{name, [&, loop] { count = runLoop(loop, vertices, settings.threads); }};
    };
    std::vector<Row> rows = {
        row("occluded1", singles(c, bare, directions), counts[0]),
        row("occluded8", packets(c, bare, directions, Packets::kAny), counts[1]),
        row("occluded8 (coherent flag)", packets(c, bare, directions, Packets::kCoherent), counts[2]),
        {"bake: trace and accumulate", bake}};
    measure(rows, settings.runs);
    printRows(c.name, rows, double(traced));
    std::printf("%-24s %zu vertices, %zu triangles, %zu rays, %.1f%% escape (%zu %zu %zu)\n", c.name.c_str(), vertices,
                c.triangles.size(), traced.load(), 100.0 * double(counts[2]) / double(traced), counts[0], counts[1],
                counts[2]);
}

// Runs four frames around the middle of the animation: pose, build, trace, accumulate, compress and write.
void benchWhole(const std::filesystem::path& rig, const Settings& settings) {
    BakeOptions options;
    options.rays = settings.rays;
    options.fps = 3;
    const BakePlan all = planBake({rig}, options);
    const std::string name = rig.filename().string();
    benchKernel(middleFrame(all, name), settings);

    const std::size_t middle = all.header.frames.frameCount() / 2, count = std::min<std::size_t>(4, middle);
    if (count == 0) return;
    std::vector<Case> cases;
    std::vector<std::unique_ptr<Bare>> scenes;
    const RayDirections directions = makeRayDirections(options.rays, options.seed, options.order);
    for (std::size_t f = middle; f < middle + count; ++f) {
        BakePlan one = all;
        one.header.frames.clip = {all.header.frames.clip[f]};
        one.header.frames.time = {all.header.frames.time[f]};
        cases.push_back(middleFrame(one, name));
        scenes.push_back(std::make_unique<Bare>(cases.back()));
    }
    options.frames = FrameRange{middle, middle + count, 1};
    const BakePlan plan = planBake({rig}, options);
    const std::filesystem::path out =
        std::filesystem::temp_directory_path() / ("bench_bake" + std::to_string(::getpid()) + ".vis.h5");
    double rays = 0;
    const auto bare = [&](Packets order) {
        for (std::size_t f = 0; f < count; ++f)
            runLoop(packets(cases[f], *scenes[f], directions, order), cases[f].positions.size(), settings.threads);
    };
    std::vector<Row> rows = {
        {"occluded8", [&] { bare(Packets::kAny); }},
        {"occluded8 (coherent flag)", [&] { bare(Packets::kCoherent); }},
        {"bake: the whole stage, " + std::to_string(count) + " frames",
         [&] { rays = bakeVisibility(plan, options, {out}, settings.threads, ProgressStyle::kNone).rays_traced; }}};
    measure(rows, settings.runs);
    std::filesystem::remove(out);
    printRows(name, rows, rays);
}

}  // namespace

int main(int argc, char** argv) {
    Settings settings;
    std::vector<std::filesystem::path> rigs;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const bool has_value = i + 1 < argc;
        if (word == "--rays" && has_value)
            settings.rays = std::atoi(argv[++i]);
        else if (word == "--threads" && has_value)
            settings.threads = std::atoi(argv[++i]);
        else if (word == "--runs" && has_value)
            settings.runs = std::atoi(argv[++i]);
        else
            rigs.emplace_back(word);
    }
    if (const char* data = std::getenv("PENUMBRA_DATA"); rigs.empty() && data)
        rigs.push_back(std::filesystem::path(data) / "rigs" / "mh_male_cmu05.glb");
    try {
        benchKernel(bumpySphere(70), settings);
        for (const auto& rig : rigs) benchWhole(rig, settings);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_bake: %s\n", error.what());
        return 1;
    }
    return 0;
}
