// Measures the time that triangles with opacity cost, and the error of the light below them.
//   bench_alpha [--rays N] [--runs N] [--rings N]
// Times are CPU seconds of one thread for the rays of all vertices of a bumpy sphere, the least of some runs, as ratios
// to the same scene without opacity in the same run. The error is that of E in the middle below a card with hair
// painted on it, against a quadrature of its alpha.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>

#include "bake/source/surface_opacity.h"
#include "bake/trace/moments.h"
#include "formats/source/source_readers.h"
#include "tests/formats/textured_rig.h"

using namespace penumbra;

namespace {

struct Settings {
    int rays = 1024, runs = 5, rings = 50;
};

struct Sphere {
    std::vector<Vec3> positions, normals;
    std::vector<Triangle> triangles;
};

Sphere bumpySphere(int rings) {
    Sphere s;
    const int columns = 2 * rings;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const double t = std::numbers::pi * (i + 0.5) / (rings + 1), p = 2 * std::numbers::pi * j / columns;
            const Vec3d d{std::sin(t) * std::cos(p), std::cos(t), std::sin(t) * std::sin(p)};
            s.positions.push_back(
                toFloat(d * 0.3 * (1 + 0.25 * std::sin(6 * d.x) * std::sin(5 * d.y) * std::sin(4 * d.z))));
        }
    const auto at = [&](int i, int j) { return std::uint32_t(i * columns + j % columns); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            s.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            s.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    s.normals = vertexNormals(s.triangles, s.positions);
    return s;
}

// Every `step`-th triangle has 8 pieces along an edge. One of the last row is clear, and the others have this value.
Opacity everyOf(std::size_t triangles, std::size_t step, std::uint8_t value) {
    Opacity out;
    for (std::size_t t = 0; t < triangles; t += step) {
        out.triangles.push_back(std::uint32_t(t));
        out.pieces.push_back(8);
        out.first.push_back(0);
    }
    out.values.assign(64, value);
    out.values.back() = 0;
    return out;
}

double traceSeconds(const Sphere& s, const OcclusionScene& scene, const RayDirections& directions) {
    std::vector<float> b(s.positions.size() * 25);
    const std::clock_t start = std::clock();
    traceMoments({scene, directions, {}, 1e-4f}, s.positions, s.normals, {b});
    return double(std::clock() - start) / CLOCKS_PER_SEC;
}

// Outside few rays hit anything, as on most of a character; inside every ray does, which costs the most.
enum class Place { kOutside, kInside };

void benchCost(const Settings& settings, Place place) {
    Sphere s = bumpySphere(settings.rings);
    for (Vec3& n : s.normals)
        if (place == Place::kInside) n = -n;
    std::printf("rays from the %s of a bumpy sphere of %zu triangles\n", place == Place::kInside ? "inside" : "outside",
                s.triangles.size());
    const RayDirections directions = makeRayDirections(settings.rays, 1, 5);
    struct Row {
        const char* name;
        Opacity opacity;
        double seconds = std::numeric_limits<double>::infinity();
    };
    std::vector<Row> rows{{"no opacity", {}},
                          {"a tenth of the triangles, nearly opaque", everyOf(s.triangles.size(), 10, kStopsAll)},
                          {"a tenth of the triangles, half clear", everyOf(s.triangles.size(), 10, 128)},
                          {"all triangles, nearly opaque", everyOf(s.triangles.size(), 1, kStopsAll)},
                          {"all triangles, half clear", everyOf(s.triangles.size(), 1, 128)},
                          {"no opacity, again (what the order of rows does)", {}}};
    std::vector<OcclusionScene> scenes;
    for (const Row& row : rows)
        scenes.emplace_back(s.positions, s.triangles, Queries::kPlain, SeeThrough{&row.opacity, {}});
    for (int run = 0; run < settings.runs; ++run)
        for (std::size_t r = 0; r < rows.size(); ++r)
            rows[r].seconds = std::min(rows[r].seconds, traceSeconds(s, scenes[r], directions));
    for (const Row& row : rows)
        std::printf("%-48s %7.3f CPU s   ratio %.3f\n", row.name, row.seconds, row.seconds / rows[0].seconds);
}

constexpr int kWidth = 64, kHeight = 64;

// Strands of hair: alpha falls from the middle of each to its edges, and towards the tips.
double strandAlpha(int column, int row) {
    const double across = std::abs(std::fmod(column + 0.5, 8.0) - 4) / 4, along = (row + 0.5) / kHeight;
    return std::clamp(1.6 - 1.3 * across - 0.8 * along, 0.0, 1.0);
}

Rig hairCard(const char* mode) {
    Image image{kWidth, kHeight, {}, {}};
    for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < kWidth; ++column) {
            const auto a = float(std::round(strandAlpha(column, row) * 255) / 255);
            image.pixels.push_back({a, a, a});
            image.alpha.push_back(a);
        }
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    const std::string name = "bench_alpha" + std::to_string(::getpid());
    writePng(folder / (name + ".png"), image, 1);
    const Vec3 a{-1, 0.2f, -1}, b{1, 0.2f, -1}, c{1, 0.2f, 1}, d{-1, 0.2f, 1};
    samples::EditableGlb glb =
        samples::texturedRig({{{a, c, b}, {{{0, 0}, {1, 1}, {1, 0}}}}, {{a, d, c}, {{{0, 0}, {0, 1}, {1, 1}}}}},
                             samples::readText(folder / (name + ".png")));
    glb.json["materials"][0]["alphaMode"] = mode;
    glb.json["textures"][0]["sampler"] = 0;
    glb.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33071}}};
    samples::writeText(folder / (name + ".glb"), glb.bytes());
    Rig rig = readRig({folder / (name + ".glb")});
    readOpacity(rig);
    std::filesystem::remove(folder / (name + ".png"));
    std::filesystem::remove(folder / (name + ".glb"));
    return rig;
}

// E at the origin below the card: 1 - integral of alpha h^2 / (pi (x^2 + z^2 + h^2)^2) dA, with the bilinear alpha of
// glTF, by the midpoint rule over 32 x 32 places a texel.
double expectedAmbient(bool mask) {
    constexpr int kFine = 32;
    constexpr double kCardHeight = 0.2;
    double hidden = 0;
    for (int j = 0; j < kHeight * kFine; ++j)
        for (int i = 0; i < kWidth * kFine; ++i) {
            const double u = (i + 0.5) / kFine - 0.5, v = (j + 0.5) / kFine - 0.5;
            const int column = int(std::floor(u)), row = int(std::floor(v));
            const double s = u - column, t = v - row;
            const auto at = [](int x, int y) {
                return std::round(strandAlpha(std::clamp(x, 0, kWidth - 1), std::clamp(y, 0, kHeight - 1)) * 255) / 255;
            };
            double alpha = (1 - t) * ((1 - s) * at(column, row) + s * at(column + 1, row)) +
                           t * ((1 - s) * at(column, row + 1) + s * at(column + 1, row + 1));
            if (mask) alpha = alpha >= 0.5 ? 1 : 0;
            const double x = 2 * (u + 0.5) / kWidth - 1, z = 2 * (v + 0.5) / kHeight - 1;
            const double square = x * x + z * z + kCardHeight * kCardHeight;
            hidden += alpha * kCardHeight * kCardHeight / (std::numbers::pi * square * square);
        }
    return 1 - hidden * 4 / (double(kWidth) * kFine * kHeight * kFine);
}

void benchError(const char* mode, int rays) {
    const Rig rig = hairCard(mode);
    const OcclusionScene scene(rig.mesh.rest_positions, rig.mesh.triangles, Queries::kPlain, {&rig.mesh.opacity, {}});
    const RayDirections directions = makeRayDirections(rays, 1, 2);
    std::vector<LaneWeights> above(directions.packets.size());
    aboveHorizon(directions, {0, 1, 0}, Floor::kNone, above);
    scene.removeOccluded({0, 0, 0}, directions, above);
    std::vector<float> b(4);
    accumulateMoments(directions, above, b);
    const double e = -double(b[1]) / (std::numbers::pi * std::sqrt(3 / (4 * std::numbers::pi)));
    const double expected = expectedAmbient(std::string(mode) == "MASK");
    std::printf("hair card, %-5s %6d rays: E %.4f, expected %.4f, error %+.4f; %zu bytes of opacity\n", mode, rays, e,
                expected, e - expected, rig.mesh.opacity.values.size());
}

}  // namespace

int main(int argc, char** argv) {
    Settings settings;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string word = argv[i];
        (word == "--rays" ? settings.rays : word == "--runs" ? settings.runs : settings.rings) = std::atoi(argv[i + 1]);
    }
    for (const Place place : {Place::kOutside, Place::kInside}) benchCost(settings, place);
    for (const char* mode : {"BLEND", "MASK"})
        for (const int rays : {1024, 16384}) benchError(mode, rays);
    return 0;
}
