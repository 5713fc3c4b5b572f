// Whole pictures of scenes by the GLSL path against the CPU's.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "pack/pack_asset.h"
#include "player/bench/scene_gpu_cost.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/scene_on_gpu.h"
#include "player/render/scene_picture.h"
#include "tests/difference.h"
#include "tests/sun_light.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_scene_on_gpu {
namespace {

namespace fs = std::filesystem;

// A folder with fields.pnb, which casts by fields; spheres.pnb, which casts by spheres; and deep.pnb, whose model has
// more bands than fields, so that the CPU computes its numbers.
class SceneOnGpuTest : public ::testing::Test {
protected:
    fs::path folder_ = fs::path(::testing::TempDir()) / "scene_gpu";

    void SetUp() override {
        fs::create_directories(folder_);
        synthetic::TubeOptions tube{
            .rings = 24, .segments = 9, .joints = 5, .clusters = 4, .components = 5, .inputs = 4};
        write(folder_ / "fields.pnb", synthetic::composedTube(tube), {});
        writeSpheres(folder_ / "spheres.pnb", tube, 0.25f);
        write(folder_ / "sunny.pnb", synthetic::composedTube(tube), {}, sunny());
        const synthetic::TubeOptions fine{
            .rings = 90, .segments = 24, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};
        write(folder_ / "fine.pnb", synthetic::composedTube(fine), {});
        writeSpheres(folder_ / "fine_spheres.pnb", fine, 0.2f);
        tube.convention.order = kFieldOrder + 1;
        write(folder_ / "deep.pnb", synthetic::composedTube(tube), {});
    }
    // A tube with a sphere at each joint.
    static void writeSpheres(const fs::path& file_name, const synthetic::TubeOptions& tube, float radius) {
        const Model model = synthetic::tubeModel(tube);
        SphereBlockers blockers;
        for (std::size_t j = 0; j < model.joint_centers.size(); ++j) {
            blockers.spheres.push_back({model.joint_centers[j], radius});
            blockers.joints.push_back(std::uint16_t(j));
        }
        write(file_name, model, blockers);
    }
    // A light with a sun.
    static LightFile sunny() {
        return synthetic::withSun(synthetic::light(4, 0.3), {normalized(Vec3d{0.5, 0.8, 0.3}), {3, 2.5, 2}, 0.01});
    }
    static void write(const fs::path& file_name, const Model& model, const SphereBlockers& blockers,
                      const LightFile& light = synthetic::light(4, 0.3)) {
        BrdfFile lambert = synthetic::lambert(), mirror = lambert;
        lambert.lobes = {{BrdfModel::kLambert, {}, {0.5f, 0.5f, 0.5f}}};
        mirror.name = "mirror";
        mirror.lobes = {{BrdfModel::kMirror, {0.9f, 0, 0, 0}, {1, 1, 1}}};
        // It sends more back to a lower eye, and other colours along its tangent.
        BrdfFile shiny = lambert;
        shiny.name = "shiny";
        for (std::size_t i = 0; i < shiny.slices.size(); i += 7) shiny.slices[i] += 0.1 * std::sin(double(i));
        const Packed packed =
            packAsset(model, std::vector<BrdfFile>{lambert, mirror, shiny}, std::vector<LightFile>{light},
                      {.precision = AssetPrecision::kI8, .blockers = blockers}, "{}", 1);
        std::ofstream file(file_name, std::ios::binary);
        file.write(reinterpret_cast<const char*>(packed.bytes.data()), std::streamsize(packed.bytes.size()));
    }
    // Returns the largest difference of a channel, in steps of 255 of the brightest one, and whether some pixels differ
    // from a picture without casters by more than a tenth of that.
    std::pair<double, bool> difference(const std::string& members, Channel channel, int resolution) const {
        RenderOptions options;
        options.width = options.height = 96;
        options.channel = channel;
        options.camera = "pitch=35,yaw=20";
        options.samples = 1;
        options.bounces = Bounces::kDirect;  // the GPU has no light between members
        const auto picture = [&](const std::string& text, EvaluationPath path) {
            options.path = path;
            const PosedScene scene(
                parseScene(R"({"version": 1, "characters": [)" + text + R"(], "light": {"rotation": "yaw=40"},)" +
                               R"("ground": {"height": -0.3, "size": 3, "casts": false, "resolution": )" +
                               std::to_string(resolution) + "}}",
                           "s.json", folder_));
            return drawScene(scene, options, 1).image;
        };
        std::string nobody = members;
        for (std::size_t at = 0;
             members.find("casts") == members.npos && (at = nobody.find("{\"asset", at)) != nobody.npos; at += 2)
            nobody.insert(at + 1, R"("casts": "nothing", )");
        const Image cpu = picture(members, EvaluationPath::kCpu), gpu = picture(members, EvaluationPath::kGlsl),
                    without = picture(nobody, EvaluationPath::kGlsl);
        Largest brightest, worst, shadow;
        int outlines = 0;
        for (std::size_t p = 0; p < cpu.pixels.size(); ++p) {
            if (cpu.alpha[p] != gpu.alpha[p]) {
                ++outlines;
                continue;
            }
            for (int c = 0; c < 3; ++c) {
                brightest.add(cpu.pixels[p][c]);
                worst.add(std::abs(double(cpu.pixels[p][c]) - double(gpu.pixels[p][c])));
                shadow.add(double(without.pixels[p][c]) - double(gpu.pixels[p][c]));
            }
        }
        // Fewer triangles show a smooth ground on the CPU, so that its edge may pass on the other side of a pixel.
        EXPECT_LE(outlines, resolution > 24 ? 2 : 0);
        return {255 * worst / brightest, shadow > 0.1 * brightest};
    }
};

// The bound is the project's, 0.5 of a step. Measured: 6e-4 without deep.pnb, and 9e-3 with it. A ground of 24 x 24
// vertices is too coarse for the CPU to interpolate it.
TEST_F(SceneOnGpuTest, PicturesAreThoseOfTheCpu) {
    const std::string fields = R"({"asset": "fields.pnb", "position": [-0.2, 0, 0.1], "yaw": 50},
                                  {"asset": "fields.pnb", "position": [0.3, 0, 0], "yaw": -70, "time": 0.1})",
                      spheres = R"({"asset": "spheres.pnb", "position": [-0.1, 0, -0.5], "yaw": 160})",
                      deep = R"({"asset": "deep.pnb", "position": [0.7, 0, 0.4], "yaw": 20})";
    for (const std::string& members : {fields, spheres, fields + "," + spheres + "," + deep})
        for (const Channel channel : {Channel::kAmbient, Channel::kShaded}) {
            // Each program takes seconds to compile.
            if (channel == Channel::kShaded && members.find("deep") == members.npos) continue;
            const auto [worst, has_shadow] = difference(members, channel, 24);
            std::printf("%s: within %.1e of a step\n", channel == Channel::kShaded ? "shaded" : "ao", worst);
            EXPECT_LT(worst, 0.5);
            EXPECT_TRUE(has_shadow);
        }
}

// Characters whose meshes are fine enough for anchors, so near that some casters are summed there and some are not.
// Measured: 2e-3. Without anchors on the GPU the worst is 0.6 to 2.4. The points of the ground are so far apart that it
// has no anchors, which a GPU does not have there.
TEST_F(SceneOnGpuTest, AnchorsAreThoseOfTheCpu) {
    const std::string fields = R"({"asset": "fine.pnb", "position": [-0.2, 0, 0.1], "yaw": 50},
                                  {"asset": "fine.pnb", "position": [0.35, 0, 0], "yaw": -70, "time": 0.1})",
                      spheres = R"({"asset": "fine_spheres.pnb", "position": [-0.1, 0, -0.6], "yaw": 160},
                                   {"asset": "fine_spheres.pnb", "position": [0.5, 0, -0.6]})";
    for (const std::string& members : {spheres, fields + "," + spheres}) {  // programs take seconds to compile
        const auto [worst, has_shadow] = difference(members, Channel::kAmbient, 12);
        std::printf("anchors: within %.1e of a step\n", worst);
        EXPECT_LT(worst, 0.5);
        EXPECT_TRUE(has_shadow);
    }
}

// Suns, a mirror and a turned character. Measured: no pixel of 16,384 is above the bound.
TEST_F(SceneOnGpuTest, SunsAreThoseOfTheCpu) {
    RenderOptions options;
    options.width = options.height = 128;
    options.channel = Channel::kShaded;
    options.camera = "pitch=35,yaw=20";
    options.samples = 1;
    options.bounces = Bounces::kDirect;
    const auto picture = [&](EvaluationPath path, SunChoice suns) {
        options.path = path;
        options.suns = suns;
        const PosedScene scene(
            parseScene(R"({"version": 1, "characters": [{"asset": "sunny.pnb", "position": [-0.2, 0, 0.1], "yaw": 50},
                           {"asset": "sunny.pnb", "position": [0.4, 0, 0], "yaw": -70, "material": "mirror"}],
                           "light": {"rotation": "yaw=40"}, "ground": {"height": -0.3, "size": 3, "casts": false, "resolution": 24}})",
                       "s.json", folder_));
        return drawScene(scene, options, 1).image;
    };
    const Image cpu = picture(EvaluationPath::kCpu, SunChoice::kOn),
                gpu = picture(EvaluationPath::kGlsl, SunChoice::kOn),
                without = picture(EvaluationPath::kGlsl, SunChoice::kOff);
    Largest brightest;
    for (const Vec3 pixel : cpu.pixels) brightest.add(luminance(pixel));
    std::size_t other = 0, lit = 0;
    for (std::size_t p = 0; p < cpu.pixels.size(); ++p) {
        EXPECT_EQ(cpu.alpha[p], gpu.alpha[p]);
        other += !(std::abs(luminance(cpu.pixels[p] - gpu.pixels[p])) <= 0.5 / 255 * brightest);
        lit += luminance(gpu.pixels[p] - without.pixels[p]) > 0.05 * brightest;
    }
    std::printf("suns: %zu of %zu pixels differ by more than 0.5 of a step\n", other, cpu.pixels.size());
    EXPECT_LE(double(other), 0.002 * double(cpu.pixels.size()));  // at edges of shadows
    EXPECT_GT(double(lit), 0.1 * double(cpu.pixels.size()));
}

// Returns the largest difference between two pictures in steps of 255 of the brightest number of the first.
double stepsBetween(const Image& cpu, const Image& gpu) {
    return 255 * largestDifference(cpu.pixels, gpu.pixels) / largestOf(cpu.pixels);
}

// The GPU looks for horizons, shades the field and shadows the characters on it. Measured: 2.5e-3 of a step.
TEST_F(SceneOnGpuTest, GroundsWithHeightsAreThoseOfTheCpu) {
    struct Case {
        const char *heights, *ground, *casts;
        Channel channel;
    };
    const Case cases[] = {
        {R"("analytic": "dunes:height=0.4,length=1.5", "rows": 61, "columns": 70, "cell": 0.05)", "", "",
         Channel::kShaded},
        {R"("analytic": "waves:height=0.3,length=1", "rows": 64, "columns": 48, "cells": [0.05, 0.07], "order": 4,
            "border": "periodic")",
         R"("material": "shiny", )", "", Channel::kShaded},
        {R"("analytic": "waves:height=0.3,length=1", "rows": 33, "columns": 70, "cell": 0.05, "border": "open",
            "step": 2)",
         "", R"("casts": "nothing", )", Channel::kAmbient},
        {R"("analytic": "waves:height=0.1,length=0.3+ripples", "rows": 43, "columns": 59, "cell": 0.05,
            "border": "periodic", "step": 8, "refine": 0.03)",
         "", "", Channel::kShaded},
        {R"("analytic": "waves:height=0.1,length=0.3+ripples", "rows": 43, "columns": 59, "cell": 0.05, "step": 8,
            "order": 4, "refine": 0.03)",
         R"("material": "shiny", )", "", Channel::kShaded},
        {R"("analytic": "dunes:height=0.4,length=1.5", "rows": 1, "columns": 70, "cell": 0.05, "step": 8)", "", "",
         Channel::kAmbient}};
    RenderOptions options;
    options.width = options.height = 96;
    options.camera = "pitch=35,yaw=20";
    options.samples = 1;
    for (const Case& one : cases) {
        options.channel = one.channel;
        const auto picture = [&](EvaluationPath path, const std::string& heights) {
            options.path = path;
            PosedScene scene(
                parseScene(R"({"version": 1, "characters": [{)" + std::string(one.casts) +
                               R"("asset": "fields.pnb", "position": [-0.2, 0.1, 0.1], "yaw": 50, "on_ground": true}],
                    "light": {"rotation": "yaw=40"}, "ground": {)" +
                               one.ground + R"("height": -0.3, "heights": {)" + heights + "}}}",
                           "s.json", folder_));
            scene.pose(0.4);
            return drawScene(scene, options, 1).image;
        };
        const Image cpu = picture(EvaluationPath::kCpu, one.heights), gpu = picture(EvaluationPath::kGlsl, one.heights);
        const Image level = picture(EvaluationPath::kGlsl, R"("analytic": "waves:height=0", "rows": 61, "columns": 70,
                                                              "cell": 0.05)");
        const double worst = stepsBetween(cpu, gpu);
        std::printf("heights: within %.1e of a step; %.1f from a level field\n", worst, stepsBetween(cpu, level));
        EXPECT_EQ(cpu.alpha, gpu.alpha);
        EXPECT_LT(worst, 0.5);
        EXPECT_GT(stepsBetween(cpu, level), 20);
    }
}

// Steps of the origin are taken away exactly, so that the same scene 40 km from the origin and 9 km high, or on heights
// of 98 km, has the same pixels. Between steps floats are a little coarser; measured: 0.02 of a step.
TEST_F(SceneOnGpuTest, FarFromTheOriginPicturesAreThoseAtTheOrigin) {
    RenderOptions options;
    options.width = options.height = 96;
    options.channel = Channel::kShaded;
    options.samples = 1;
    const auto picture = [&](EvaluationPath path, const std::string& place, const std::string& second,
                             const std::string& ground, const std::string& target) {
        options.path = path;
        options.camera = "pitch=35,yaw=20,distance=4,target=" + target;
        const PosedScene scene(
            parseScene(R"({"version": 1, "characters": [{"asset": "fields.pnb", "position": )" + place +
                           R"(}, {"asset": "fields.pnb", "yaw": 70, "on_ground": true, "position": )" + second +
                           R"(}], "light": {"rotation": "yaw=40"}, "ground": {)" + ground + "}}",
                       "s.json", folder_));
        return drawScene(scene, options, 1).image;
    };
    const std::string dunes = R"(, "heights": {"analytic": "dunes:height=0.5,length=2", "rows": 60, "columns": 60,
                                 "cell": 0.0625, "offset": )";
    for (const EvaluationPath path : {EvaluationPath::kCpu, EvaluationPath::kGlsl}) {
        const Image level = picture(path, "[-0.25, 0.125, 0]", "[0.5, 0.25, 0]",
                                    R"("height": -0.25, "size": 3, "casts": false)", "0/0/0"),
                    far = picture(path, "[40959.75, 9216.125, -2048]", "[40960.5, 0.25, -2048]",
                                  R"("height": 9215.75, "size": 3, "casts": false, "centre": [40960, 0, -2048])",
                                  "40960/9216/-2048");
        EXPECT_EQ(level.alpha, far.alpha);
        EXPECT_EQ(level.pixels, far.pixels);
        const Image field = picture(path, "[-0.25, 0.125, 0]", "[0.5, 0.25, 0]", R"("height": -0.25)" + dunes + "0}",
                                    "0/0/0"),
                    high = picture(path, "[3071.75, 98304.125, 0]", "[3072.5, 0.25, 0]",
                                   R"("height": -0.25, "centre": [3072, 0, 0])" + dunes + "98304}", "3072/98304/0"),
                    between = picture(path, "[-0.25, 9000.125, 0]", "[0.5, 0.25, 0]",
                                      R"("height": -0.25)" + dunes + "9000}", "0/9000/0");
        EXPECT_EQ(field.pixels, high.pixels);
        EXPECT_EQ(field.alpha, between.alpha);
        std::printf("9 km high: within %.1e of a step\n", stepsBetween(field, between));
        EXPECT_LT(stepsBetween(field, between), 0.5);
    }
}

// A sandy ground and one that is a mirror, with the shadows of hills and of a character. Measured: no pixel of 9,216 is
// above.
TEST_F(SceneOnGpuTest, SunsOnGroundsWithHeightsAreThoseOfTheCpu) {
    RenderOptions options;
    options.width = options.height = 96;
    options.channel = Channel::kShaded;
    options.camera = "pitch=35,yaw=20";
    options.samples = 1;
    for (const std::string material : {"", R"("material": "mirror", )"}) {
        const auto picture = [&](EvaluationPath path, SunChoice suns) {
            options.path = path;
            options.suns = suns;
            const PosedScene scene(
                parseScene(R"({"version": 1, "characters": [{"asset": "sunny.pnb", "position": [-0.2, 0.1, 0.1],
                               "on_ground": true}], "light": {"rotation": "yaw=40"}, "ground": {)" +
                               material + R"("heights": {"analytic": "dunes:height=0.4,length=1.5", "rows": 61,
                               "columns": 70, "cell": 0.05}}})",
                           "s.json", folder_));
            return drawScene(scene, options, 1).image;
        };
        const Image cpu = picture(EvaluationPath::kCpu, SunChoice::kOn),
                    gpu = picture(EvaluationPath::kGlsl, SunChoice::kOn),
                    without = picture(EvaluationPath::kCpu, SunChoice::kOff);
        Largest brightest;
        double least = 1e9;
        for (const Vec3 pixel : cpu.pixels) brightest.add(luminance(pixel));
        std::size_t other = 0, lit = 0;
        for (std::size_t p = 0; p < cpu.pixels.size(); ++p) {
            other += !(std::abs(luminance(cpu.pixels[p] - gpu.pixels[p])) <= 0.5 / 255 * brightest);
            lit += std::abs(luminance(gpu.pixels[p] - without.pixels[p])) > 0.05 * brightest;
            if (cpu.alpha[p] == 1) least = std::min(least, double(luminance(gpu.pixels[p])));
        }
        std::printf("%s: %zu of %zu pixels differ by more than 0.5 of a step\n", material.empty() ? "sand" : "mirror",
                    other, cpu.pixels.size());
        EXPECT_LE(double(other), 0.002 * double(cpu.pixels.size()));  // at edges of shadows
        EXPECT_GT(double(lit), 0.1 * double(cpu.pixels.size()));
        EXPECT_LT(least, 0.3 * brightest);
    }
}

// On a ground of 400 m a sun has several maps, and a tube a shadow. Measured: no pixel of 9,216 is above.
TEST_F(SceneOnGpuTest, SunsOnWideGroundsAreThoseOfTheCpu) {
    RenderOptions options;
    options.width = options.height = 96;
    options.channel = Channel::kShaded;
    options.camera = "pitch=35,yaw=20,distance=3";
    options.samples = 1;
    const auto picture = [&](EvaluationPath path, const std::string& more) {
        options.path = path;
        options.suns = SunChoice::kOn;
        const PosedScene scene(
            parseScene(R"({"version": 1, "characters": [{"asset": "sunny.pnb", "position": [-0.2, 0.1, 0.1],
                           "on_ground": true}], "ground": {"heights": {"analytic": "waves:height=0.4,length=40", )" +
                           more + "}}}",
                       "s.json", folder_));
        return drawScene(scene, options, 1).image;
    };
    const std::string wide = R"("rows": 101, "columns": 101, "cell": 4)";
    const Image cpu = picture(EvaluationPath::kCpu, wide), gpu = picture(EvaluationPath::kGlsl, wide);
    Largest brightest;
    for (const Vec3 pixel : cpu.pixels) brightest.add(luminance(pixel));
    std::size_t other = 0, dark = 0;
    for (std::size_t p = 0; p < cpu.pixels.size(); ++p) {
        other += !(std::abs(luminance(cpu.pixels[p] - gpu.pixels[p])) <= 0.5 / 255 * brightest);
        dark += cpu.alpha[p] == 1 && luminance(cpu.pixels[p]) < 0.4 * brightest;
    }
    std::printf("wide ground: %zu of %zu pixels differ by more than 0.5 of a step\n", other, cpu.pixels.size());
    EXPECT_LE(double(other), 0.002 * double(cpu.pixels.size()));  // at edges of shadows
    EXPECT_GT(dark, 200u);
}

// Pixels of a column that are darker than those three above and below.
std::size_t darkLines(const Image& image, double step) {
    std::size_t count = 0;
    const auto width = std::size_t(image.width);
    for (std::size_t p = 3 * width; p + 3 * width < image.pixels.size(); ++p) {
        const float least = std::min(luminance(image.pixels[p - 3 * width]), luminance(image.pixels[p + 3 * width]));
        count += double(luminance(image.pixels[p])) < double(least) - step;
    }
    return count;
}

// Where several samples make a pixel, the middle of one at an edge lies beside the triangle, and below the next one
// where the ground bends up.
TEST_F(SceneOnGpuTest, SunsOfManySamplesShowNoEdgesOfTriangles) {
    RenderOptions options;
    options.width = 320;
    options.height = 240;
    options.camera = "pitch=22,yaw=30,distance=60,fov=40,target=0/0/0";
    options.suns = SunChoice::kOn;
    options.sun_map = 4096;
    const PosedScene scene(
        parseScene(R"({"version": 1, "characters": [{"asset": "sunny.pnb", "on_ground": true}], "ground": {"heights":
                      {"analytic": "dunes:height=8,length=40", "rows": 256, "columns": 256, "cell": 2}}})",
                   "s.json", folder_));
    std::array<std::size_t, 2> lines{};
    for (const EvaluationPath path : {EvaluationPath::kCpu, EvaluationPath::kGlsl}) {
        options.path = path;
        for (const int samples : {1, 4}) {
            options.samples = samples;
            const Image image = drawScene(scene, options, 1).image;
            Largest brightest;
            for (const Vec3 pixel : image.pixels) brightest.add(luminance(pixel));
            lines[samples == 4] = darkLines(image, 0.05 * brightest);
        }
        std::printf("dark lines: %zu pixels of one sample, %zu of four\n", lines[0], lines[1]);
        EXPECT_LE(2 * lines[1], 3 * lines[0]);  // 248, 308
    }
}

// The GPU uploads the box of a stroke, makes the maxima above it anew and lets those receivers look that see it.
TEST_F(SceneOnGpuTest, AfterAStrokeOnlyWhatSeesItIsComputed) {
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    RenderOptions options;
    options.width = options.height = 96;
    options.channel = Channel::kAmbient;
    options.camera = "pitch=35,yaw=20";
    const auto open = [&] {
        return PosedScene(parseScene(R"({"version": 1, "characters": [{"asset": "spheres.pnb"}],
            "ground": {"heights": {"analytic": "dunes:height=0.4,length=1.5", "rows": 128, "columns": 128,
                                   "cell": 0.04, "refine": 0.01}}})",
                                     "s.json", folder_));
    };
    const OffscreenTarget target(options.width, options.height, 1);
    const auto pictureOf = [&](SceneOnGpu& gpu) {
        gpu.evaluate();
        target.begin();
        gpu.draw(gpu.view());
        return target.read();
    };
    const PosedScene scene = open(), other = open();
    SceneOnGpu gpu(scene, options, 1);
    const Image before = pictureOf(gpu);
    EXPECT_EQ(gpu.heights()->work().heights, 128u * 128u);
    EXPECT_EQ(gpu.heights()->work().receivers, 33u * 33u);
    const Vec3 at = scene.field()->heights().point(80, 40);
    for (const PosedScene* one : {&scene, &other}) one->field()->brush(at, 0.3f, 0.5f);
    const Image edited = pictureOf(gpu);
    const GlHeights::Work work = gpu.heights()->work();
    std::printf("a stroke: %zu heights, %zu maxima, %zu of %d receivers\n", work.heights, work.maxima, work.receivers,
                33 * 33);
    EXPECT_LE(work.heights, 15u * 15u);
    EXPECT_LE(work.maxima, 200u);
    EXPECT_LT(work.receivers, 33u * 33u);
    EXPECT_GT(work.receivers, 16u);
    SceneOnGpu fresh(other, options, 1);
    EXPECT_LT(stepsBetween(pictureOf(fresh), edited), 1e-6);
    EXPECT_GT(stepsBetween(before, edited), 20);
    pictureOf(gpu);
    EXPECT_EQ(gpu.heights()->work().receivers, 0u);
}

TEST_F(SceneOnGpuTest, SceneWithoutCastersIsOpen) {
    const auto [worst, has_shadow] =
        difference(R"({"asset": "fields.pnb", "casts": "nothing"})", Channel::kAmbient, 24);
    EXPECT_LT(worst, 0.5);
    EXPECT_FALSE(has_shadow);
}

TEST_F(SceneOnGpuTest, CostHasEveryStepOfScenesThatFit) {
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    RenderOptions options;
    options.width = options.height = 32;
    const auto cost = [&](const char* ground) {
        const std::string text = R"({"version": 1, "characters": [{"asset": "sunny.pnb"}], "ground": {)";
        const PosedScene scene(parseScene(text + ground + "}}", "s.json", folder_));
        return measureSceneGpuCost(scene, options, 1, 1);
    };
    const std::optional<SceneGpuCost> measured = cost(R"("resolution": 8, "casts": false)");
    ASSERT_TRUE(measured);
    EXPECT_GT(measured->until_done.evaluate, 0);
    EXPECT_GT(measured->until_done.maps, 0);
    EXPECT_GT(measured->until_done.draw, 0);
    EXPECT_FALSE(cost(R"("catcher": true)"));
    EXPECT_FALSE(cost(R"("resolution": 8)")) << "a level ground that casts";
}

}  // namespace
}  // namespace penumbra::test_scene_on_gpu
