// Tests lobes whose parameter changes while the program runs: on every path of the CPU, and on the GPU.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "player/draw/model_painter.h"
#include "player/draw/picture_view.h"
#include "player/frame/frame_values.h"
#include "player/gl/offscreen_target.h"
#include "runtime/shade/shading_set.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/player/gl_calls.h"
#include "tests/runtime/count_allocations.h"
#include "tests/runtime/synthetic_asset.h"
#include "tests/sh/golden.h"

namespace penumbra::test_live_shading {
namespace {

using player_test::GlCalls;
using player_test::SyntheticAsset;

BrdfLobe lobe(const char* text) { return lobeOf(parseBrdf(text)); }

MaterialView liveMaterial(const BrdfLobe& lobe) {
    MaterialView material{"live", 1, 1, 1, lobe.color, {}};
    material.lobes = {&lobe, 1};
    return material;
}

std::vector<float> floats(const std::vector<double>& values) { return {values.begin(), values.end()}; }

// One vertex at the origin, seen along `view`.
Vec3 shadeOne(const Convention& convention, const BrdfLobe& lobe, const LightView& light, LightForm form,
              const Mat3& frame, Vec3 view, std::span<const float> coefficients, const ShadePath& path) {
    VertexShader shader(convention, convention.size(), liveMaterial(lobe), light, {Reflectance::kSlices, form});
    shader.usePath(path);
    std::vector<Vec3> radiance(1);
    const Vec3 origin, tangent{frame.m[0], frame.m[1], frame.m[2]}, normal{frame.m[6], frame.m[7], frame.m[8]};
    shader.shade({{&origin, 1}, {&normal, 1}, {&tangent, 1}, coefficients, 0, 1}, view * 5.0f, radiance);
    return radiance[0];
}

// Radiance of six occluders, views and exponents in doubles. Measured: 1.2e-6 of radiances up to 1.1.
TEST(LiveShading, IsTheGoldenRadiance) {
    const auto golden = readGolden("phong_from_d5.json");
    for (const auto& test : golden.at("cases")) {
        std::vector<float> sh;
        for (const double value : doubles(test.at("light"))) sh.insert(sh.end(), 3, float(value));
        BrdfLobe phong = lobe("phong-live:color=1/0.5/0");
        phong.parameters[0] = test.at("alpha").get<float>();
        const double expected = test.at("radiance").get<double>();
        for (const ShadePath& path : shadePaths())
            for (const LightForm form : {LightForm::kRotation, LightForm::kFixed}) {
                const Vec3 radiance = shadeOne({}, phong, {"light", 4, sh}, form, Mat3(),
                                               toFloat(vec3(test.at("view"))), floats(doubles(test.at("d5"))), path);
                EXPECT_NEAR(double(radiance.x), expected, golden.at("tol_float").get<double>()) << path.name;
                EXPECT_NEAR(double(radiance.y), expected / 2, golden.at("tol_float").get<double>()) << path.name;
                EXPECT_EQ(radiance.z, 0);
            }
    }
}

// Moments over the hemisphere of what numbers stand for. One band more than D has pays; A and B have theirs as they
// are.
std::vector<double> momentsOf(const Convention& convention, int order, std::span<const float> coefficients) {
    std::vector<double> ones, b(std::size_t(coefficientCount(order))), below(b.size());
    for (int k = 0; k < order + convention.order - 1; ++k) ones.push_back(1 / double(k + 1));
    const std::vector<double> gram = mirrorLobeMatrix(order, convention.order, ones);
    const auto d = std::size_t(coefficientCount(convention.order));
    const std::vector<int> index = convention.indices();
    belowHorizonCoefficients(order, below);
    for (std::size_t i = 0; i < b.size(); ++i) {
        if (convention.below != BelowHorizon::kMirrored) {
            b[i] = double(coefficients[i]) - (convention.below == BelowHorizon::kOpen ? below[i] : 0);
            continue;
        }
        for (std::size_t j = 0; j < index.size(); ++j)
            b[i] += gram[i * d + std::size_t(index[j])] * double(coefficients[j]);
    }
    return b;
}

// The plain way, in doubles: turn moments and light into a frame about the mirror direction, and multiply by M.
Vec3d referenceRadiance(const Convention& convention, const BrdfLobe& lobe, int order, std::span<const float> sh,
                        const Mat3d& local, Vec3d view, std::span<const float> coefficients) {
    const bool mirrored = convention.below == BelowHorizon::kMirrored;
    const int moment_order = mirrored ? std::min(convention.order + 1, kMaxOrder) : convention.order;
    std::vector<double> of_lobe(std::size_t(order + moment_order - 1));
    mirrorLobeMoments(lobe.model, double(lobe.parameters[0]), of_lobe);
    const std::vector<double> m = mirrorLobeMatrix(order, moment_order, of_lobe);
    const auto width = std::size_t(coefficientCount(moment_order));
    const std::vector<double> b = momentsOf(convention, moment_order, coefficients);
    std::vector<double> turned(width);
    const Vec3d o = local * view, r{-o.x, -o.y, std::abs(o.z)};
    const Vec3d x = normalized(cross(std::abs(r.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, r));
    const Mat3d mirror = fromRows(x, cross(r, x), r);
    apply(makeShRotation(moment_order, mirror), b, turned);
    Vec3d radiance;
    const auto rows = std::size_t(coefficientCount(order));
    for (int c = 0; c < 3; ++c) {
        std::vector<double> light(rows), seen(rows);
        for (std::size_t i = 0; i < rows; ++i) light[i] = double(sh[3 * i + std::size_t(c)]);
        apply(makeShRotation(order, mirror * local), light, seen);
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t j = 0; j < width; ++j)
                radiance[c] += double(lobe.color[c]) * seen[i] * m[i * width + j] * turned[j];
    }
    return radiance;
}

// Frames, views (from below and along the normal too), numbers and lights at random, for every order of both, and for
// both models. Radiances reach 7. Measured: 5e-6.
TEST(LiveShading, EveryPathIsTheReferenceInDoubles) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const auto direction = [&] { return normalized(Vec3{normal(random), normal(random), normal(random)}); };
    Largest worst;
    for (const char* text : {"phong-live:exponent=0", "phong-live:exponent=7.3", "phong-live:exponent=1000",
                             "ggx-live:alpha=0.2,color=1/0.5/0.1"})
        for (const char* name : {"D1", "D4", "D5", "D8", "A4", "B5"})
            for (const int order : {1, 2, 4, 8}) {
                const Convention convention = parseConvention(name);
                const BrdfLobe live = lobe(text);
                std::vector<float> coefficients(std::size_t(convention.size())), sh(3 * std::size_t(order * order));
                for (float& x : coefficients) x = normal(random);
                for (float& x : sh) x = 0.5f * normal(random);
                const Vec3 n = direction(), t = normalized(cross(n, direction()));
                const Mat3 frame = toLocalFrame(n, t);
                for (const Vec3 view : {direction(), n, -direction()}) {
                    Mat3d exact;
                    for (std::size_t i = 0; i < 9; ++i) exact.m[i] = double(frame.m[i]);
                    const Vec3d expected =
                        referenceRadiance(convention, live, order, sh, exact, toDouble(view), coefficients);
                    for (const ShadePath& path : shadePaths()) {
                        const Vec3 radiance = shadeOne(convention, live, {"light", order, sh}, LightForm::kRotation,
                                                       frame, view, coefficients, path);
                        for (int c = 0; c < 3; ++c) worst.add(std::abs(double(radiance[c]) - expected[c]));
                    }
                }
            }
    EXPECT_LT(worst, 5e-5);
}

// A synthetic asset whose fourth material is live.
struct LiveAsset {
    SyntheticAsset data;
    BrdfLobe lobe = test_live_shading::lobe("phong-live:exponent=10,color=0.9/0.8/0.7");

    explicit LiveAsset(const player_test::AssetRecipe& recipe = {.rings = 10, .light_order = 5, .slots = 3})
        : data(recipe) {
        data.asset.materials.push_back(liveMaterial(lobe));
    }
    static constexpr std::size_t kLive = 3;
};

TEST(LiveShading, WhatCannotBeIsRefused) {
    LiveAsset live;
    ShadingSet set(live.data.asset);
    for (const double value : {-1.0, 1e5, double(NAN)}) {
        try {
            set.setParameter(LiveAsset::kLive, value);
            FAIL() << value;
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find("phong-live exponent must be a number from 0 to 1000"),
                      std::string::npos)
                << error.what();
        }
    }
}

// A change shows at once, is that of a set made with the new lobe, and allocates nothing.
TEST(LiveShading, ChangingTheExponentMakesNothing) {
    LiveAsset live;
    ShadingSet set(live.data.asset);
    set.setMaterial(LiveAsset::kLive);
    Evaluator evaluator(live.data.asset);
    Shot shot;
    shot.asset = &live.data.asset;
    FrameVertices vertices;
    evaluateFrame(shot, VisibilitySource::kModel, evaluator, 1, vertices);
    const auto shade = [&](const ShadingSet& with) {
        std::vector<Vec3> radiance(vertices.positions.size());
        with.shade(vertices.range(0, radiance.size()), {0.5f, 1, 3}, radiance);
        return radiance;
    };
    const std::vector<Vec3> before = shade(set);
    const std::uint64_t version = set.materialVersion();
    {
        const std::size_t count = allocationCount();
        set.setParameter(LiveAsset::kLive, 80);
        EXPECT_EQ(allocationCount(), count);
    }
    EXPECT_GT(set.materialVersion(), version);
    EXPECT_EQ(set.lobesOf(LiveAsset::kLive)[0].parameters[0], 80);
    LiveAsset other;
    other.lobe.parameters[0] = 80;
    ShadingSet made(other.data.asset);
    made.setMaterial(LiveAsset::kLive);
    const std::vector<Vec3> after = shade(set);
    EXPECT_EQ(after, shade(made));
    EXPECT_NE(after, before);
}

// The GPU shows the exponent of this frame, beside materials of tables and alone. Nothing is compiled or allocated.
// Colours reach 1. Measured: 3e-5, on llvmpipe; the bound is half a step of 255.
TEST(LiveShading, TheGpuGivesWhatTheCpuGives) {
    // Compiling the shader takes most of the time, so not every pair is there.
    for (const LightForm form : {LightForm::kRotation, LightForm::kFixed})
        for (const bool alone : {false, true}) {
            if (alone && form == LightForm::kFixed) continue;
            LiveAsset live;
            std::size_t material = LiveAsset::kLive;
            if (alone) {
                live.data.asset.materials = {live.data.asset.materials[material]};
                live.data.asset.slot_material.assign(3, 0);
                material = 0;
            }
            const std::unique_ptr<GlContext> context = createGlContext(GlBackend::kAuto);
            OffscreenTarget target{64, 64, 1};
            ShadingSet set(live.data.asset, {Reflectance::kSlices, form});
            set.setMaterial(0, material);
            Evaluator evaluator(live.data.asset);
            Shot shot;
            shot.asset = &live.data.asset;
            FrameVertices vertices;
            evaluateFrame(shot, VisibilitySource::kModel, evaluator, 1, vertices);
            RenderOptions options;
            options.width = options.height = 64;
            const FrameView view = makePictureView(options, live.data.asset, vertices.positions);
            ModelPainter painter(std::make_shared<GlAsset>(live.data.asset, &set), 1);
            ValuePainter values(live.data.asset.mesh.triangles, Channel::kShaded);
            const auto draw = [&] {
                const PosedCharacter character{&evaluator, {}, &set};
                painter.evaluate(Channel::kShaded, {&character, 1}, view.eye);
                target.begin();
                painter.draw(view);
                return target.read();
            };
            Image last = draw();
            for (const double exponent : {0.0, 10.0, 300.0}) {
                set.setParameter(material, exponent);
                const GlCalls calls;
                const Image drawn = draw();
                EXPECT_EQ(calls.made(), 0) << exponent;
                std::vector<Vec3> radiance;
                shadeFrame(set, vertices, view.eye, 1, radiance);
                target.begin();
                values.draw(view, vertices.positions, radiance);
                const Image expected = target.read();
                EXPECT_LT(largestDifference(drawn.pixels, expected.pixels), 0.5f / 255)
                    << exponent << " form " << int(form);
                EXPECT_GT(largestOf(expected.pixels), 0.1);
                if (!alone || exponent != 10) {
                    EXPECT_NE(drawn.pixels, last.pixels) << exponent;
                }
                last = drawn;
            }
        }
}

}  // namespace
}  // namespace penumbra::test_live_shading
