// Tests the scenes of the accuracy table in docs/formulas.md section 3, and the brute-force integral that its errors
// are relative to. The table itself is in tests/accuracy/test_shading_tables.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fit/reflectance/fit_brdf.h"
#include "fit/reflectance/shading_error.h"
#include "sh/quadrature.h"
#include "tests/fit/golden_scenes.h"

namespace penumbra::test_shading_scenes {
namespace {

const Convention kD5{BelowHorizon::kMirrored, 5};

// The constants in the program equal the golden ones to the last digit.
TEST(ShadingScenes, AreTheGoldenOnes) {
    const ShadingScenes golden = scenesOfGolden(readGolden("scene_seed11.json")), ours = referenceScenes();
    ASSERT_EQ(ours.occluders.size(), 61u);
    ASSERT_EQ(golden.occluders.size(), 61u);
    for (std::size_t k = 0; k < 61; ++k) {
        ASSERT_EQ(ours.occluders[k].size(), golden.occluders[k].size());
        for (std::size_t i = 0; i < ours.occluders[k].size(); ++i) {
            const OccluderPart &a = ours.occluders[k][i], &b = golden.occluders[k][i];
            EXPECT_TRUE(a.kind == b.kind && a.direction == b.direction && a.cosine == b.cosine) << k;
        }
    }
    EXPECT_EQ(ours.lights, golden.lights);
    ASSERT_EQ(ours.views.size(), 54u);
    ASSERT_EQ(golden.views.size(), 54u);
    for (std::size_t v = 0; v < 54; ++v) EXPECT_EQ(ours.views[v], golden.views[v]);
}

// Compares the matrix product with plain sums in double, for one view of an anisotropic BRDF under a coloured light.
TEST(ShadingError, BruteForceIsTheIntegral) {
    ShadingScenes scenes = referenceScenes();
    scenes.views = {scenes.views[40]};
    const RgbBrdf brdf = rgbBrdf(parseBrdf("ward:ax=0.2,ay=0.5,color=1/0.5/0.25"));
    const std::vector<double> radiance = bruteForceRadiance(makeShadingTest(scenes, 2), brdf, 2);
    for (std::size_t light : {0u, 5u})
        for (std::size_t k : {0u, 3u, 30u, 60u}) {
            double sum = 0, y[16];
            for (const auto& [direction, weight] : gaussHemisphere(64, 256)) {
                if (isBlocked(scenes.occluders[k], direction)) continue;
                evalBasis(4, direction, y);
                double incoming = 0;
                for (std::size_t i = 0; i < 16; ++i) incoming += scenes.lights[light][i] * y[i];
                sum += weight * direction.z * incoming * brdf.eval(direction, scenes.views[0]).x;
            }
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(radiance[(c * 6 + light) * 61 + k], sum / double(1 << c), 1e-12 * std::abs(sum));
        }
}

// An open point under a light of order 1 sees radiance y_0 E. Lambert reflects it times 1 / pi with E = pi. D5 holds
// this exactly.
TEST(ShadingError, OpenLambertUnderConstantLightIsExact) {
    ShadingScenes scenes = referenceScenes();
    scenes.occluders = {{}};
    scenes.lights = {std::vector<double>(16)};
    scenes.lights[0][0] = 2;
    const ShadingTest test = makeShadingTest(scenes, 1);
    const BrdfSpec lambert = parseBrdf("lambert");
    const std::vector<double> truth = bruteForceRadiance(test, rgbBrdf(lambert), 1);
    EXPECT_NEAR(truth[0], 2 / std::sqrt(4 * 3.14159265358979), 1e-9);
    const BrdfFile brdf = fitBrdf(rgbBrdf(lambert), {}, 1);
    const auto slices = slicesOfViews(scenes.views, brdf.slices, brdf.even_index);
    EXPECT_LT(shadingError({test, truth}, kD5, slices, 5), 1e-6);  // the numbers are single precision
    std::vector<double> doubled = slices;
    for (double& f : doubled) f *= 2;
    EXPECT_NEAR(shadingError({test, truth}, kD5, doubled, 5), 1, 1e-6);
}

// A Phong lobe seen along the normal reflects all of a constant light, however narrow it is: its integral with the
// cosine is (s + 2) / 2 pi 2 pi / (s + 2) = 1. The shared grid has no point in a lobe of exponent 100000. A cap down to
// z = 0.9 in front of the mirror direction leaves 0.9^(s + 2), within 2.4e-3, because its edge lies between two rings
// of the grid.
TEST(ShadingError, NarrowLobesAreNotMissed) {
    ShadingScenes scenes = referenceScenes();
    scenes.views = {{0, 0, 1}};
    scenes.occluders = {{}, {{OccluderPart::kCap, {0, 0, 1}, 0.9}}};
    scenes.lights = {std::vector<double>(16)};
    scenes.lights[0][0] = std::sqrt(4 * std::numbers::pi);
    const ShadingTest test = makeShadingTest(scenes, 1);
    for (const char* text : {"phong:exponent=10", "phong:exponent=1000", "phong:exponent=100000"}) {
        const std::vector<double> truth = bruteForceRadiance(test, rgbBrdf(parseBrdf(text)), 1);
        ASSERT_EQ(truth.size(), 6u);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(truth[2 * c], 1, 1e-3) << text;
        EXPECT_NEAR(truth[1], std::pow(0.9, parseBrdf(text).parameters.at("exponent") + 2), 4e-3) << text;
    }
}

TEST(ShadingError, SameResultForAnyThreadCount) {
    const ShadingScenes scenes = referenceScenes();
    for (const char* text : {"ggx", "phong:exponent=3000"}) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const std::vector<double> one = bruteForceRadiance(makeShadingTest(scenes, 1), brdf, 1);
        for (int threads : {2, 8})
            EXPECT_EQ(bruteForceRadiance(makeShadingTest(scenes, threads), brdf, threads), one) << text;
    }
}

}  // namespace
}  // namespace penumbra::test_shading_scenes
