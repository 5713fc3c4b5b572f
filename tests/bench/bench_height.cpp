// What a height field costs and how far it is from the truth. Figures are of the processor's time of one thread, which
// other programs hardly change; frames are also timed on two threads.
//
//   bench_height                 waves of 128^2 to 1024^2 points: cost by step, and sub-sampling against full
//   resolution bench_height DEM.npz [CELL]  rms V of a file's heights against traced horizons
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

SceneGround wavesOf(int side, int order, int step) {
    SceneGround ground;
    SceneHeights& heights = ground.heights.emplace();
    heights.source.analytic = "waves:height=0.25,length=4,count=5";
    heights.source.rows = heights.source.columns = side;
    heights.source.cell_rows = heights.source.cell_columns = 0.05;
    heights.order = order;
    heights.step = step;
    return ground;
}

std::vector<float> skySh(double sun_height) {
    char text[96];
    std::snprintf(text, sizeof text, "sky:turbidity=3,elevation=%g", sun_height);
    const std::vector<double> sh = projectLights(partsOf(parseLights(text)), 5);
    return {sh.begin(), sh.end()};
}

void timeWaves(const LightView& light) {
    std::printf("%6s %5s %4s | %8s %8s %8s %8s | %10s %9s | %9s %6s\n", "side", "order", "step", "heights", "look",
                "shade", "all", "ns a point", "ratio", "2 threads", "Hz");
    double first = 0;
    for (const auto& [side, order, step] : std::initializer_list<std::array<int, 3>>{
             {128, 4, 4}, {256, 4, 4}, {512, 4, 4}, {1024, 4, 4}, {512, 5, 4}, {512, 4, 8}, {512, 4, 2}, {512, 4, 1}}) {
        const SceneGround ground = wavesOf(side, order, step);
        SceneField field(ground);
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
        std::printf("%6d %5d %4d | %8.2f %8.2f %8.2f %8.2f | %10.1f %9.3f | %9.2f %6.1f\n", side, order, step,
                    heights.processor, looked.processor, shaded.processor, all, point, point / first, frame.wall,
                    1000 / frame.wall);
    }
}

Image pictureOf(const SceneGround& ground, const LightView& light) {
    SceneField field(ground);
    AssetView asset;
    FieldLook look(ground, field.convention(), asset, light);
    FrameVertices points;
    std::vector<Vec3> radiance;
    field.evaluate(2, points);
    look.shade(points, {0, 9, 9}, 2, radiance);
    return {ground.heights->source.columns, ground.heights->source.rows, std::move(radiance), {}};
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

void compareSteps() {
    for (const double sun : {10.0, 30.0, 60.0}) {
        const std::vector<float> sh = skySh(sun);
        const LightView light{"sky", 5, sh};
        const Image full = pictureOf(wavesOf(512, 5, 1), light);
        float most = 0;
        for (const Vec3 p : full.pixels) most = std::max(most, p.y);
        std::printf("sun %2.0f degrees high: FLIP of a map from above, 512^2, against full resolution:", sun);
        for (const int step : {2, 4, 8}) {
            const Image picture = pictureOf(wavesOf(512, 5, step), light);
            std::printf("  step %d %.4f", step, meanFlip(full, picture, 0.8f / most));
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
    compareSteps();
}
