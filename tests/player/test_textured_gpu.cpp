// Pictures on a mesh: the GLSL path, the window and scenes against the CPU path of `render`.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "formats/common/write_file.h"
#include "player/composite/photograph_frames.h"
#include "player/draw/model_painter.h"
#include "player/frame/frame_values.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/render/render_offscreen.h"
#include "player/render/scene_picture.h"
#include "player/view/view_look.h"
#include "player/view/view_painter.h"
#include "tests/difference.h"
#include "tests/player/gl_calls.h"
#include "tests/runtime/count_allocations.h"
#include "tests/sun_light.h"
#include "tests/synthetic_composition.h"
#include "tests/textured_tube.h"

namespace penumbra::test_textured_gpu {
namespace {

namespace fs = std::filesystem;
using player_test::GlCalls;
using synthetic::TexturedSlots;

// A light with a sun beside its SH.
LightFile sunnyLight() {
    return synthetic::withSun(synthetic::light(4, 0.3), {normalized(Vec3d{0.5, 0.4, 0.8}), {3, 2.5, 2}, 0.01});
}

RenderOptions smallPicture(bool textures = true) {
    RenderOptions options;
    options.width = 64;
    options.height = 128;
    options.samples = 1;
    options.camera = "pitch=10,yaw=30";
    options.textures = textures;
    return options;
}

// The largest difference of pixels that both cover, in steps of 255 of the brightest channel, and how many only one
// covers.
struct Compared {
    double steps = 0;
    std::size_t covered = 0, outlines = 0;
};
Compared compare(const Image& a, const Image& b) {
    Compared out;
    Largest brightest, worst;
    for (std::size_t p = 0; p < a.pixels.size(); ++p) {
        out.outlines += a.alpha[p] != b.alpha[p];
        if (a.alpha[p] == 0 || b.alpha[p] == 0) continue;
        ++out.covered;
        for (int c = 0; c < 3; ++c) {
            brightest.add(std::max(a.pixels[p][c], b.pixels[p][c]));
            worst.add(std::abs(double(a.pixels[p][c]) - double(b.pixels[p][c])));
        }
    }
    out.steps = 255 * worst / brightest;
    return out;
}

class TexturedGpu : public testing::Test {
protected:
    fs::path folder_ = fs::path(testing::TempDir()) / ("textured_gpu_" + std::to_string(getpid()));
    const synthetic::TubeOptions tube_{.rings = 16, .segments = 12};

    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }
};

// Two slots, of which one has holes, with normal maps, two roughnesses, emission and occlusion; with a sun the pixels
// shade it by their own normal. Measured: 0.06 of a step, at outlines. The bound is that of scenes.
TEST_F(TexturedGpu, PicturesAreThoseOfTheCpu) {
    for (const bool sun : {false, true}) {
        // With the sun vertices have colours, too.
        const std::vector<std::byte> bytes =
            sun ? synthetic::texturedTube(TexturedSlots::kTinted, sunnyLight(), tube_)
                : synthetic::texturedTube(TexturedSlots::kClothAndCard, synthetic::light(4, 0.3), tube_);
        const AssetView asset = openAsset(bytes);
        RenderOptions options = smallPicture();
        options.path = EvaluationPath::kCpu;
        const Image cpu = renderOffscreen(options, asset, nullptr, 1).image;
        options.path = EvaluationPath::kGlsl;
        const RenderResult gpu = renderOffscreen(options, asset, nullptr, 1);
        EXPECT_EQ(gpu.path, EvaluationPath::kGlsl);
        const Compared same = compare(cpu, gpu.image);
        std::printf("%s: within %.1e of a step over %zu pixels, %zu of outlines\n", sun ? "sun" : "sky", same.steps,
                    same.covered, same.outlines);
        EXPECT_LT(same.steps, 0.5);
        EXPECT_LE(same.outlines, 2u);
        EXPECT_GT(same.covered, 500u);
        options.textures = false;
        const Compared plain = compare(cpu, renderOffscreen(options, asset, nullptr, 1).image);
        EXPECT_GT(plain.steps, 20) << "the pictures are not seen";
        EXPECT_GT(plain.outlines, 50u) << "the holes are not cut";
    }
}

// Vertices that all have one colour show what a base colour and an alpha show that are multiplied by it.
TEST_F(TexturedGpu, ColoursOfVerticesAreFactorsOfTheBaseColour) {
    const Model model = synthetic::tubeModel(tube_);
    const auto drawn = [&](bool by_vertices, EvaluationPath path) {
        SurfaceLook look = synthetic::texturedLook(model, TexturedSlots::kCloth);
        SlotSurface& slot = look.surface.slots[0];
        slot.alpha_cutoff = 0.5f;
        if (by_vertices)
            look.surface.colors.assign(3 * model.mesh.triangles.size(), {13107, 39321, 65535, 52428});
        else
            slot.base = slot.base * Vec3{0.2f, 0.6f, 1}, slot.alpha *= 0.8f;
        const std::array<LightFile, 1> lights = {sunnyLight()};
        const std::vector<std::byte> bytes =
            packAsset(model, std::vector<BrdfFile>{}, lights,
                      {.precision = AssetPrecision::kF32, .surface = std::move(look)}, "{}", 1)
                .bytes;
        RenderOptions options = smallPicture();
        options.path = path;
        return renderOffscreen(options, openAsset(bytes), nullptr, 1).image;
    };
    for (const EvaluationPath path : {EvaluationPath::kCpu, EvaluationPath::kGlsl}) {
        const Compared same = compare(drawn(false, path), drawn(true, path));
        EXPECT_LT(same.steps, 0.01);
        EXPECT_EQ(same.outlines, 0u);
        EXPECT_GT(same.covered, 500u);
    }
}

// Two walls whose alpha is a half cover three quarters in the mean. Most pixels of the tube see two; those that look in
// at its open end see one. With one sample a pixel, both paths cover the same ones.
TEST_F(TexturedGpu, BlendingCoversAsMuchAsAlphaSays) {
    const Model model = synthetic::tubeModel(tube_);
    const auto drawn = [&](float alpha, int samples, EvaluationPath path) {
        SurfaceLook look = synthetic::texturedLook(model, TexturedSlots::kLevel);
        look.surface.slots[0].alpha = alpha;
        look.surface.slots[0].alpha_cutoff = kBlendAlpha;
        look.surface.slots[0].use(TextureRole::kBaseColor) = {};
        const std::array<LightFile, 1> lights = {synthetic::light(4, 0.3)};
        const std::vector<std::byte> bytes =
            packAsset(model, std::vector<BrdfFile>{}, lights,
                      {.precision = AssetPrecision::kF32, .surface = std::move(look)}, "{}", 1)
                .bytes;
        RenderOptions options = smallPicture();
        options.samples = samples;
        options.path = path;
        return renderOffscreen(options, openAsset(bytes), nullptr, 1).image;
    };
    for (const int samples : {1, 4}) {
        const Image whole = drawn(1, samples, EvaluationPath::kCpu), half = drawn(0.5f, samples, EvaluationPath::kCpu);
        if (samples == 1) {
            EXPECT_LT(compare(drawn(0.5f, samples, EvaluationPath::kGlsl), half).steps, 0.5);
        }
        double alpha = 0;
        std::size_t pixels = 0;
        for (std::size_t p = 0; p < whole.alpha.size(); ++p)
            if (whole.alpha[p] == 1) alpha += double(half.alpha[p]), ++pixels;
        ASSERT_GT(pixels, 500u);
        std::printf("%d samples: mean alpha %.3f over %zu pixels\n", samples, alpha / double(pixels), pixels);
        EXPECT_NEAR(alpha / double(pixels), 0.75, 0.04);
    }
}

// Each of two characters, turned in the scene, has another slot without its picture.
TEST_F(TexturedGpu, ScenesAreThoseOfTheCpu) {
    writeWholeFile(folder_ / "a.pnb",
                   synthetic::texturedTube(TexturedSlots::kClothAndCard, synthetic::light(4, 0.3), tube_));
    const PosedScene scene(parseScene(R"({"version": 1, "characters": [
        {"asset": "a.pnb", "position": [-0.3, 0, 0], "yaw": 50, "slots": {"card": "f0 of 0"}},
        {"asset": "a.pnb", "position": [0.3, 0, 0.1], "yaw": -70, "slots": {"cloth": "f90 of 0"}}]})",
                                      "s.json", folder_));
    RenderOptions options = smallPicture();
    options.width = 128;
    options.path = EvaluationPath::kCpu;
    const Image cpu = drawScene(scene, options, 1).image;
    options.path = EvaluationPath::kGlsl;
    const Compared same = compare(cpu, drawScene(scene, options, 1).image);
    std::printf("scene: within %.1e of a step over %zu pixels\n", same.steps, same.covered);
    EXPECT_LT(same.steps, 0.5);
    EXPECT_LE(same.outlines, 2u);
}

// The window on both paths, while materials change and beside a file whose materials come first.
TEST_F(TexturedGpu, TheWindowDrawsThePictureOfBothPaths) {
    const fs::path tube = folder_ / "a.pnb", other = folder_ / "b.pnb";
    writeWholeFile(tube, synthetic::texturedTube(TexturedSlots::kClothAndCard, synthetic::light(4, 0.3), tube_));
    const std::array grey = {synthetic::lambert({0.3, 0.3, 0.3})};
    const std::array light = {synthetic::light(3, 0)};
    writeWholeFile(other,
                   packAsset(synthetic::tubeModel(), grey, light, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    const OffscreenTarget target(96, 96, 1);
    const auto drawn = [&](std::span<const fs::path> files, EvaluationPath path, bool textures, int material) {
        Scene scene = openScene(files, 1, {.reading = {}, .textures = textures});
        ViewState state = stateFor(scene, {});
        state.camera.target = {0, 0.9, 0};
        state.camera.distance = 5;
        if (material >= 0) state.characters[0].material_of_slot[0] = std::uint16_t(material);
        ScenePainter painter(scene, path);
        UpdateCost cost;
        updateScene(scene, state, painter.needs(state, 1), cost);
        PaintCost paint;
        target.begin();
        painter.draw(state, 96, {0, 0, 96, 96}, paint);
        gl::Disable(GL_SCISSOR_TEST);
        return target.read();
    };
    for (const std::vector<fs::path>& files : {std::vector{tube}, std::vector{other, tube}})
        for (const int material : {-1, 1}) {
            const Image cpu = drawn(files, EvaluationPath::kCpu, true, material),
                        gpu = drawn(files, EvaluationPath::kGlsl, true, material),
                        plain = drawn(files, EvaluationPath::kCpu, false, material);
            const Compared same = compare(cpu, gpu);
            std::printf("window of %zu files: within %.1e of a step\n", files.size(), same.steps);
            EXPECT_LT(same.steps, 0.5);
            EXPECT_GT(compare(cpu, plain).steps, 20) << "the pictures are not seen";
        }
}

// A character in a photograph has the pixels of `render` with the same camera, sun and pictures, and what it throws
// onto the ground has its colours: less than the white of its parts. Measured: 6e-4 of a step.
TEST_F(TexturedGpu, PhotographsHaveThePictures) {
    writeWholeFile(folder_ / "a.pnb",
                   synthetic::textured(synthetic::composedTube({.rings = 12, .segments = 9, .joints = 6}),
                                       TexturedSlots::kCloth, sunnyLight()));
    PosedScene scene(parseScene(R"({"version": 1, "characters": [{"asset": "a.pnb", "position": [0, 0.1, 0]}],
        "camera": {"f": 150, "size": [160, 120], "R": [[1, 0, 0], [0, -0.447213595, -0.894427191],
                   [0, 0.894427191, -0.447213595]], "t": [0, 0, 4.47213595]},
        "ground": {"catcher": true, "height": -0.2}})",
                                "s.json", folder_));
    RenderOptions options = smallPicture();
    options.sun_map = 256;
    options.width = 160;
    options.height = 120;
    options.camera.clear();
    options.path = EvaluationPath::kCpu;
    const auto photograph = [&](bool textures) {
        options.textures = textures;
        PhotographFrames frames(scene, options, 1);
        PhotographFrame frame;
        frames.compute(0, {}, frame);
        return frame;
    };
    const PhotographFrame white = photograph(false), pictured = photograph(true);
    const Compared same = compare(drawScene(scene, options, 1).image, pictured.characters);
    std::printf("photograph: within %.1e of a step over %zu pixels, %zu of outlines\n", same.steps, same.covered,
                same.outlines);
    EXPECT_LT(same.steps, 0.5);
    EXPECT_GT(same.covered, 500u);
    EXPECT_LE(same.outlines, 2u);
    EXPECT_GT(compare(white.characters, pictured.characters).steps, 20);
    double more = 0;
    for (std::size_t p = 0; p < white.ratio.size(); ++p) more += double(white.ratio[p].x - pictured.ratio[p].x);
    EXPECT_GT(more, 0.1);
}

// A frame after the first makes no GL object and allocates no byte.
TEST_F(TexturedGpu, AFrameAllocatesNothing) {
    const std::vector<std::byte> bytes = synthetic::texturedTube(TexturedSlots::kClothAndCard, sunnyLight(), tube_);
    const AssetView asset = openAsset(bytes);
    const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
    const OffscreenTarget target(32, 32, 1);
    ShadingSet set(asset);
    set.showSurface();
    Evaluator evaluator(asset);
    const auto shared = std::make_shared<GlAsset>(asset, &set);
    ModelPainter painter(shared, 1);
    const PosedCharacter character{&evaluator, {}, &set};
    const auto frame = [&](std::size_t i) {
        evaluator.setFrame(i % asset.animation.frameCount());
        set.setMaterial(1, i % 2);
        painter.evaluate(Channel::kShaded, {&character, 1}, {0, 0, 3});
        target.begin();
        painter.draw(FrameView());
    };
    for (std::size_t i = 0; i < 4; ++i) frame(i);
    const GlCalls calls;
    const std::size_t before = allocationCount();
    for (std::size_t i = 0; i < 50; ++i) frame(i);
    EXPECT_EQ(calls.made(), 0);
    EXPECT_EQ(allocationCount(), before);
    // Position, value, normal and three slopes, then A and B of two steps: 10 vec4 a vertex.
    EXPECT_EQ(shared->evaluatedQuads(Channel::kShaded, 0), 10u);
}

}  // namespace
}  // namespace penumbra::test_textured_gpu
