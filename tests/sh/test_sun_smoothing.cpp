#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sh/light/sun_smoothing.h"

namespace penumbra::test_sun_smoothing {
namespace {

SunD sunAt(double angle, double irradiance) {
    return {{std::cos(angle), std::sin(angle), 0}, Vec3d{1, 1, 1} * irradiance, 0};
}

double totalOf(std::span<const SunD> suns) {
    double sum = 0;
    for (const SunD& sun : suns) sum += luminance(sun.irradiance);
    return sum;
}

// One step of t and a hundred of t / 100 leave the same: exp(-t / time constant) of the difference.
TEST(SunSmoothing, FollowsExponentially) {
    for (const int steps : {1, 100}) {
        SunSmoothing filter(0.1);
        const std::vector<SunD> from = {sunAt(0, 1)}, to = {sunAt(0.3, 3)};
        filter.update(from, 1, 0);
        std::span<const SunD> suns;
        for (int i = 0; i < steps; ++i) suns = filter.update(to, 1, 0.05 / steps);
        ASSERT_EQ(suns.size(), 1u);
        const double left = std::exp(-0.5);
        EXPECT_NEAR(suns[0].irradiance.x, 3 - 2 * left, 1e-12);
        EXPECT_NEAR(std::atan2(suns[0].direction.y, suns[0].direction.x), 0.3 * (1 - left), 1e-12);
        EXPECT_NEAR(length(suns[0].direction), 1, 1e-12);
    }
}

TEST(SunSmoothing, TheFirstSunsAndThoseWithoutAFilterAreAsTheyCome) {
    SunSmoothing filter(0.1), off(0);
    const std::vector<SunD> first = {sunAt(0, 2), sunAt(2, 1)}, second = {sunAt(1, 5)};
    EXPECT_EQ(filter.update(first, 3, 0.01).size(), 2u);
    off.update(first, 3, 0.01);
    const std::span<const SunD> suns = off.update(second, 3, 0);
    ASSERT_EQ(suns.size(), 1u);
    EXPECT_EQ(suns[0].irradiance.x, 5);
    filter.reset();
    EXPECT_EQ(filter.update(second, 3, 0)[0].irradiance.x, 5);
}

// After 1 / 256 of it is left, a sun that vanished is gone: within 0.56 s at 0.1 s.
TEST(SunSmoothing, ASunThatVanishesFades) {
    SunSmoothing filter(0.1);
    const std::vector<SunD> suns = {sunAt(0, 2)};
    filter.update(suns, 1, 0);
    double last = 2;
    for (int i = 0; i < 56; ++i) {
        const double now = totalOf(filter.update({}, 1, 0.01));
        EXPECT_LT(now, last);
        EXPECT_GT(now, 0.9 * last - 0.01);
        last = now;
    }
    EXPECT_TRUE(filter.update({}, 1, 0.01).empty());
}

// With room for two, the new sun fades in while the old one fades out. With room for one it waits.
TEST(SunSmoothing, ASunThatJumpsFadesOver) {
    for (const std::size_t most : {1u, 2u}) {
        SunSmoothing filter(0.1);
        const std::vector<SunD> from = {sunAt(0, 2)}, to = {sunAt(1.5, 2)};
        filter.update(from, most, 0);
        std::span<const SunD> suns = filter.update(to, most, 0.01);
        EXPECT_EQ(suns.size(), most);
        EXPECT_NEAR(suns[0].direction.x, 1, 1e-12) << "it stays where it is";
        if (most == 2) {
            EXPECT_NEAR(totalOf(suns), 2, 1e-12) << "one takes what the other gives";
        }
        for (int i = 0; i < 300; ++i) suns = filter.update(to, most, 0.01);
        ASSERT_EQ(suns.size(), 1u);
        EXPECT_NEAR(suns[0].direction.y, std::sin(1.5), 1e-9);
        EXPECT_NEAR(totalOf(suns), 2, 1e-6);
    }
}

TEST(SunSmoothing, RefusesTimesThatAreNone) {
    SunSmoothing filter(0.1);
    for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(filter.update({}, 1, bad), std::invalid_argument);
        EXPECT_THROW(filter.setTimeConstant(bad), std::invalid_argument);
    }
}

}  // namespace
}  // namespace penumbra::test_sun_smoothing
