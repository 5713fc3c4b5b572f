// Suns of the run time: what is shaded without them, how they turn, and how they are found in live lights.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "runtime/shade/shading_set.h"
#include "sh/angles.h"
#include "sh/light/light_rotation.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_shading_suns {
namespace {

using player_test::SyntheticAsset;

const Mat3d kTurn = parseLightRotation("yaw=40,pitch=-25,roll=160");

Mat3 toFloats(const Mat3d& a) {
    Mat3 out;
    for (std::size_t i = 0; i < 9; ++i) out.m[i] = float(a.m[i]);
    return out;
}

// The coefficients of suns over a uniform light of radiance 0.3.
std::vector<float> lightOf(std::span<const Sun> suns, int order) {
    std::vector<float> sh(3 * std::size_t(coefficientCount(order)), 0.0f);
    std::vector<Sun> negative(suns.begin(), suns.end());
    for (Sun& sun : negative) sun.irradiance *= -1;
    for (int c = 0; c < 3; ++c) sh[std::size_t(c)] = 0.3f * 3.5449077f;
    subtractSuns(negative, {}, sh);
    return sh;
}

struct Lit {
    SyntheticAsset data{{.rings = 6, .light_order = 4}};
    std::vector<Sun> suns = {{{0.6f, 0.8f, 0}, {5, 4, 3}, 0.005f}};
    std::vector<float> sh = lightOf(suns, 4);

    explicit Lit(std::span<const float> window = {}) {
        data.asset.lights = {{"sun", 4, sh, {}, suns, window}, {"other", 4, sh}};
    }
};

std::vector<Vec3> coefficientsOf(const ShadingSet& set) { return set.lightTables().sh(); }

TEST(ShadingSuns, OffIsTheWholeLightBitForBit) {
    const Lit lit;
    ShadingSet with(lit.data.asset), without(lit.data.asset);
    without.setLight(1);
    with.setLightRotation(toFloats(kTurn));
    without.setLightRotation(toFloats(kTurn));
    EXPECT_TRUE(with.suns().empty());
    EXPECT_EQ(coefficientsOf(with), coefficientsOf(without));
    with.setSuns(true);
    EXPECT_NE(coefficientsOf(with), coefficientsOf(without));
    with.setSuns(false);
    EXPECT_EQ(coefficientsOf(with), coefficientsOf(without));
    EXPECT_TRUE(with.suns().empty());
}

// The sun is the whole of bands 1 to 3 here. Rotations leave 1e-6 of 5.
TEST(ShadingSuns, OnIsTheRemainderAndTurnedSuns) {
    const Lit lit;
    ShadingSet set(lit.data.asset);
    set.setSuns(true);
    for (const Mat3d& turn : {Mat3d{}, kTurn}) {
        set.setLightRotation(toFloats(turn));
        std::vector<Vec3> rest = coefficientsOf(set);
        EXPECT_NEAR(rest[0].x, 0.3f * 3.5449077f, 1e-5f);
        rest.erase(rest.begin());
        EXPECT_LT(largestMagnitude(rest), 1e-5f);
        ASSERT_EQ(set.suns().size(), 1u);
        EXPECT_LT(length(set.suns()[0].direction - toFloat(turn * Vec3d{0.6, 0.8, 0})), 1e-6f);
        EXPECT_EQ(set.suns()[0].irradiance, lit.suns[0].irradiance);
        EXPECT_EQ(set.suns()[0].radius, 0.005f);
    }
    set.setLight(1);
    EXPECT_TRUE(set.suns().empty()) << "the other light has none";
}

// The window applies to the light with its suns, so the suns have the same window.
TEST(ShadingSuns, TheWindowOfTheLightIsTheWindowOfItsSuns) {
    const std::vector<float> window = {1, 0.8f, 0.5f, 0.2f};
    Lit lit(window);
    for (std::size_t i = 0; i < lit.sh.size(); ++i) lit.sh[i] *= window[std::size_t(bandOfIndex(int(i / 3)))];
    ShadingSet set(lit.data.asset);
    set.setSuns(true);
    std::vector<Vec3> rest = coefficientsOf(set);
    rest.erase(rest.begin());
    EXPECT_LT(largestMagnitude(rest), 1e-5f);
}

// Live lights without factorLive() have no suns. With it, suns and remainder are the light at every moment, while the
// sun moves, jumps and goes.
TEST(ShadingSuns, LiveLightsAreFactoredAndAddUp) {
    const Lit lit;
    ShadingSet set(lit.data.asset);
    set.setSuns(true);
    set.setLight(0, lit.sh);
    EXPECT_TRUE(set.suns().empty());
    set.factorLive(0, 1, 0.1);
    const std::vector<float> even = lightOf({}, 4);
    for (int frame = 0; frame < 120; ++frame) {
        const double angle = frame < 40 ? 0.01 * frame : 2;
        const Sun sun{{float(std::cos(angle)), float(std::sin(angle)), 0}, {5, 4, 3}, 0};
        const std::vector<float> sh = frame < 80 ? lightOf(std::span(&sun, 1), 4) : even;
        const std::size_t before = allocationCount();
        set.setLight(0, sh, 1.0 / 60);
        const std::span<const Sun> suns = set.suns();
        EXPECT_EQ(allocationCount(), before);
        std::vector<float> rest = sh;
        subtractSuns(suns, {}, rest);
        for (std::size_t i = 0; i < rest.size(); ++i)
            EXPECT_NEAR(rest[i], coefficientsOf(set)[i / 3][int(i % 3)], 1e-5f) << frame;
        if (frame == 39) {
            ASSERT_EQ(suns.size(), 1u);
            EXPECT_NEAR(suns[0].irradiance.x, 5, 0.1f);
            EXPECT_LT(length(suns[0].direction - sun.direction), 0.1f) << "0.1 s behind";
        }
    }
    for (int frame = 0; frame < 60; ++frame) set.setLight(0, even, 1.0 / 60);
    EXPECT_TRUE(set.suns().empty());
}

}  // namespace
}  // namespace penumbra::test_shading_suns
