// Measures the time that a height field takes and its error against the truth. Figures are of the processor's time of
// one thread, which other programs hardly change; frames are also timed on two threads.
//
//   bench_height                 waves of 128^2 to 1024^2 points: cost by step and with more receivers where cells
//                                need them; sub-sampling of waves, dunes and a steep fractal against full resolution
//   bench_height DEM.npz [CELL]  rms V of a file's heights against traced horizons
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <random>

#include "formats/height/height_file.h"
#include "formats/image/image_file.h"
#include "player/render/flip.h"
#include "player/scene/scene_field.h"
#include "sh/light/analytic_light.h"
#include "tests/sh/height_samples.h"
#include "tests/sh/horizon_reference.h"

namespace penumbra {
namespace {

double processorMilliseconds() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

double wallMilliseconds() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Taken {
    double processor = 1e9, wall = 1e9;  // the least of some runs, milliseconds
};

template <class Body>
Taken timeOf(const Body& body) {
    Taken best;
    for (int run = 0; run < 9; ++run) {
        const double processor = processorMilliseconds(), wall = wallMilliseconds();
        body(run);
        best.processor = std::min(best.processor, processorMilliseconds() - processor);
        best.wall = std::min(best.wall, wallMilliseconds() - wall);
    }
    return best;
}

SceneGround groundOf(const char* analytic, int side, double cell, int order, int step, double refine) {
    SceneGround ground;
    SceneHeights& heights = ground.heights.emplace();
    heights.source.analytic = analytic;
    heights.source.rows = heights.source.columns = side;
    heights.source.cell_rows = heights.source.cell_columns = cell;
    heights.order = order;
    heights.step = step;
    heights.refine = refine;
    return ground;
}

const char* const kWaves = "waves:height=0.25,length=4,count=5";

std::vector<float> skySh(double sun_height) {
    char text[96];
    std::snprintf(text, sizeof text, "sky:turbidity=3,elevation=%g", sun_height);
    const std::vector<double> sh = projectLights(partsOf(parseLights(text)), 5);
    return {sh.begin(), sh.end()};
}

void timeWaves(const LightView& light) {
    std::printf("%6s %5s %4s %7s | %8s %8s %8s %8s | %10s %9s | %9s %6s\n", "side", "order", "step", "refine",
                "heights", "look", "shade", "all", "ns a point", "ratio", "2 threads", "Hz");
    struct Case {
        int side, order, step;
        double refine = double(kHeightTolerance);
    };
    double first = 0;
    for (const auto& [side, order, step, refine] :
         {Case{128, 4, 4}, Case{256, 4, 4}, Case{512, 4, 4}, Case{512, 4, 4, 0}, Case{1024, 4, 4}, Case{512, 5, 4},
          Case{512, 5, 4, 0}, Case{512, 4, 8}, Case{512, 4, 2}, Case{512, 4, 1}}) {
        const SceneGround ground = groundOf(kWaves, side, 0.05, order, step, refine);
        SceneField field(ground, GroundHeights(ground));
        AssetView asset;
        FieldLook look(ground, field.convention(), asset, light);
        FrameVertices points;
        std::vector<Vec3> radiance;
        double seconds = 0;
        const Taken heights = timeOf([&](int) { field.pose(seconds += 0.03); });
        const Taken looked = timeOf([&](int) {
            field.lookAgain();
            field.evaluate(1, points);
        });
        const Taken shaded = timeOf([&](int) { look.shade(points, {0, 9, 9}, 1, radiance); });
        const Taken frame = timeOf([&](int) {
            field.pose(seconds += 0.03);
            field.evaluate(2, points);
            look.shade(points, {0, 9, 9}, 2, radiance);
        });
        const double all = heights.processor + looked.processor + shaded.processor, point = 1e6 * all / side / side;
        if (first == 0) first = point;
        std::printf("%6d %5d %4d %7.3f | %8.2f %8.2f %8.2f %8.2f | %10.1f %9.3f | %9.2f %6.1f\n", side, order, step,
                    refine, heights.processor, looked.processor, shaded.processor, all, point, point / first,
                    frame.wall, 1000 / frame.wall);
    }
}

// A map from above, and what it took to look for its horizons.
struct Map {
    Image picture;
    double milliseconds;
};

// `heights` stand for those of the ground, if there are any.
Map mapOf(const SceneGround& ground, std::span<const float> heights, const LightView& light) {
    SceneField field(ground, GroundHeights(ground));
    const int side = ground.heights->source.rows;
    if (!heights.empty()) field.set({0, 0, side, side}, heights);
    AssetView asset;
    FieldLook look(ground, field.convention(), asset, light);
    FrameVertices points;
    std::vector<Vec3> radiance;
    const double start = processorMilliseconds();
    field.evaluate(2, points);
    const double taken = processorMilliseconds() - start;
    look.shade(points, {0, 9, 9}, 2, radiance);
    return {{side, side, std::move(radiance), {}}, taken};
}

double meanFlip(const Image& full, const Image& picture, float exposure) {
    std::vector<Vec3> a = full.pixels, b = picture.pixels;
    for (std::vector<Vec3>* pixels : {&a, &b})
        for (Vec3& p : *pixels)
            for (int c = 0; c < 3; ++c) p[c] = std::min(p[c] * exposure, 1.0f);
    double sum = 0;
    for (const float e : flipMap(full.width, full.height, a, b, 0)) sum += double(e) / double(a.size());
    return sum;
}

// Steps with more receivers where cells need them, and without.
void compareSteps(const char* name, const char* analytic, int side, double cell, std::span<const float> heights) {
    for (const double sun : {10.0, 30.0, 60.0}) {
        const std::vector<float> sh = skySh(sun);
        const LightView light{"sky", 5, sh};
        const auto map = [&](int step, double refine) {
            return mapOf(groundOf(analytic, side, cell, 5, step, refine), heights, light);
        };
        const Map full = map(1, 0);
        float most = 0;
        for (const Vec3 p : full.picture.pixels) most = most > p.y || std::isnan(most) ? most : p.y;  // NaN stays
        std::printf("%s, sun %2.0f degrees high, FLIP of a map from above against full resolution (%.0f ms):", name,
                    sun, full.milliseconds);
        for (const int step : {2, 4, 8})
            for (const double refine : {double(kHeightTolerance), 0.0}) {
                const Map one = map(step, refine);
                std::printf("  step %d%s %.4f (%.0f ms)", step, refine > 0 ? "" : " alone",
                            meanFlip(full.picture, one.picture, 0.8f / most), one.milliseconds);
            }
        std::printf("\n");
    }
}

void compareHorizons(const char* file, double cell) {
    HeightSource source;
    source.file = file;
    source.cell_rows = source.cell_columns = cell;
    source.border = HeightBorder::kOpen;
    const HeightSequence sequence(source);
    std::vector<float> heights(sequence.grid().size());
    sequence.read(0, heights);
    const HeightField field(sequence.grid(), heights);
    constexpr int kPlaces = 160;
    for (int order = 4; order <= 5; ++order) {
        const HeightTables tables(field, order, order);
        const std::size_t n = std::size_t(order * order);
        std::mt19937 random(3);
        double square = 0, bias = 0;
        for (int k = 0; k < kPlaces; ++k) {
            const float row = float(16 + random() % unsigned(field.grid().rows - 32)),
                        column = float(16 + random() % unsigned(field.grid().columns - 32)),
                        height = field.at(row, column);
            std::vector<float> v(n);
            tables.visibility(field, {&row, &column, &height, 1}, n, v);
            std::vector<double> tangents(256), truth(n);
            traceHorizon(field, row, column, 0.25f, tangents);
            horizonVisibility(order, tangents, truth);
            for (std::size_t i = 0; i < n; ++i)
                square += (double(v[i]) - truth[i]) * (double(v[i]) - truth[i]) / (4 * std::numbers::pi * kPlaces);
            bias += (double(v[0]) - truth[0]) / std::sqrt(4 * std::numbers::pi) / kPlaces;
        }
        std::printf("%s, %d x %d, cell %g m, order %d: rms V %.4f, bias %+.4f\n", file, field.grid().rows,
                    field.grid().columns, cell, order, std::sqrt(square), bias);
    }
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
    using namespace penumbra;
    if (argc > 1) {
        compareHorizons(argv[1], argc > 2 ? std::atof(argv[2]) : 1);
        return 0;
    }
    const std::vector<float> sh = skySh(30);
    timeWaves({"sky", 5, sh});
    compareSteps("waves", kWaves, 512, 0.05, {});
    compareSteps("dunes", "dunes:height=0.8,length=4", 128, 0.0625, {});
    compareSteps("fractal", kWaves, 192, 0.1, fractalHeights(192, 192, 2, 1.1));
}
