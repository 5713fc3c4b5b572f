// A light that becomes another: what it is in between, and that nothing jumps.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "player/view/light_blend.h"
#include "sh/angles.h"
#include "sh/zonal.h"
#include "tests/difference.h"

namespace penumbra::test_light_blend {
namespace {

constexpr std::size_t kOrder = 5;

// A uniform sky of radiance `sky` and suns, which are stored with it.
struct SkyAndSuns {
    std::vector<float> sh, window;
    std::vector<Sun> suns;
    int order;

    SkyAndSuns(float sky, std::vector<Sun> stored, int bands = int(kOrder), std::vector<float> factors = {})
        : window(std::move(factors)), suns(std::move(stored)), order(bands) {
        sh.resize(std::size_t(3 * bands * bands));
        for (std::size_t c = 0; c < 3; ++c) sh[c] = sky * std::sqrt(4 * std::numbers::pi_v<float>);
        for (const Sun& sun : suns) {
            const Sun negative{sun.direction, -sun.irradiance, 0};
            subtractSuns({&negative, 1}, window, sh);
        }
    }
    operator LightView() const { return {"", order, sh, {}, suns, window, {}}; }
};

Sun sunAt(double degrees_from_up, Vec3 irradiance, float radius = 0.01f) {
    const double angle = radians(degrees_from_up);
    return {toFloat(Vec3d{std::sin(angle), std::cos(angle), 0}), irradiance, radius};
}

// Returns the irradiance on upright and level squares that a frame shows, in the shadow of all suns and out of it.
std::vector<double> irradiances(const LightView& light) {
    std::vector<float> soft(light.sh.begin(), light.sh.end());
    subtractSuns(light.suns, light.window, soft);
    std::vector<double> zonal(std::size_t(light.order)), out;
    clampedCosineZonal(zonal);
    std::vector<double> weights(std::size_t(coefficientCount(light.order)));
    for (const Vec3d normal : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, 1}}) {
        rotateZonal(zonal, normal, weights);
        double shadow = 0, lit = 0;
        for (std::size_t i = 0; i < weights.size(); ++i) shadow += weights[i] * double(soft[3 * i]);
        for (const Sun& sun : light.suns)
            lit += double(sun.irradiance.x) * std::max(0.0, dot(normal, toDouble(sun.direction)));
        out.push_back(shadow);
        out.push_back(shadow + lit);
    }
    return out;
}

struct Sweep {
    Largest largest_step, range;
    std::size_t most_suns = 0;
    double seconds = 0;  // until it is over
};

// Goes from lights[0] to lights[1] in steps of `dt`. The steps at both ends count.
Sweep sweep(LightBlend& blend, std::span<const LightView> lights, int order, double dt) {
    blend.advance(lights, order, 0, 0);
    std::vector<double> last = irradiances(lights[0]);
    Sweep out;
    const auto compare = [&](const LightView& light) {
        const std::vector<double> now = irradiances(light);
        for (std::size_t i = 0; i < now.size(); ++i) {
            out.largest_step.add(std::abs(now[i] - last[i]));
            out.range.add(now[i]);
        }
        last = now;
        out.most_suns = std::max(out.most_suns, light.suns.size());
    };
    for (;;) {
        blend.advance(lights, order, 1, dt);
        out.seconds += dt;
        if (!blend.active()) break;
        compare(blend.light());
    }
    compare(lights[1]);
    return out;
}

TEST(LightBlend, TheFirstLightIsTakenAsItIs) {
    const SkyAndSuns a(1, {sunAt(30, {3, 3, 3})}), b(2, {});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend blend;
    const std::uint64_t version = blend.version();
    blend.advance(lights, 5, 1, 0.02);
    blend.advance(lights, 5, 1, 0.02);
    EXPECT_FALSE(blend.active());
    EXPECT_EQ(blend.version(), version);
    EXPECT_EQ(blend.part(), 1);
}

TEST(LightBlend, IsOneLightLessAndTheOtherMore) {
    const SkyAndSuns a(1, {sunAt(30, {3, 3, 3})}), b(2, {sunAt(-50, {1, 2, 4})});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend blend({.seconds = 1, .sun_time = 0.1});
    blend.advance(lights, 5, 0, 0);
    blend.advance(lights, 5, 1, 0.25);
    ASSERT_TRUE(blend.active());
    EXPECT_EQ(blend.part(), 0.25);
    EXPECT_EQ(blend.from(), 0u);
    const LightView light = blend.light();
    for (std::size_t i = 0; i < a.sh.size(); ++i) EXPECT_NEAR(light.sh[i], 0.75f * a.sh[i] + 0.25f * b.sh[i], 1e-5f);
    // A light without a picture of its own is seen as its SH, with ringing below 0 as 0.
    EXPECT_EQ(blend.sky().width, 256);
    EXPECT_EQ(blend.sky().texels.size(), 256u * 128u);
}

// The suns stand in the east and in the west, 80 degrees apart, and are as strong as the sky. In 50 frames a second the
// largest change of any irradiance was .027 of the largest irradiance with the filter and .039 without, where the
// stored suns turn into those that are found. A light that is switched at once changes by .47.
TEST(LightBlend, NothingJumps) {
    const SkyAndSuns a(1, {sunAt(40, {4, 4, 4})}), b(1, {sunAt(-40, {3, 3, 3})});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend smooth({.seconds = 1, .sun_time = 0.1}), plain({.seconds = 1, .sun_time = 0});
    const Sweep filtered = sweep(smooth, lights, 5, 0.02), unfiltered = sweep(plain, lights, 5, 0.02);
    LightBlend switched({.seconds = 0});
    const Sweep jump = sweep(switched, lights, 5, 0.02);
    EXPECT_GT(jump.largest_step, 0.4 * jump.range);
    EXPECT_LT(filtered.largest_step, 0.035 * filtered.range);
    EXPECT_LT(unfiltered.largest_step, 0.055 * unfiltered.range);
    EXPECT_GE(filtered.most_suns, 1u);
    EXPECT_NEAR(filtered.seconds, 1.8, 0.03) << "the filter settles in 8 time constants";
    EXPECT_NEAR(unfiltered.seconds, 1, 0.03);
}

// A light that is switched on the way begins a new blend where the old one stands.
TEST(LightBlend, TurnsBackWhereItStands) {
    const SkyAndSuns a(1, {sunAt(40, {4, 4, 4})}), b(1, {sunAt(-40, {3, 3, 3})});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend blend({.seconds = 1, .sun_time = 0.1});
    blend.advance(lights, 5, 0, 0);
    for (int i = 0; i < 25; ++i) blend.advance(lights, 5, 1, 0.02);
    const std::vector<double> before = irradiances(blend.light());
    blend.advance(lights, 5, 0, 0);
    EXPECT_EQ(blend.part(), 0);
    EXPECT_EQ(blend.from(), 1u);
    const std::vector<double> turned = irradiances(blend.light());
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(turned[i], before[i], 1e-5);
    for (int i = 0; i < 200 && blend.active(); ++i) blend.advance(lights, 5, 0, 0.02);
    EXPECT_FALSE(blend.active());
}

// Near a sun that a light has stored, its direction and radius are kept: a sun that only fades does not wander.
TEST(LightBlend, AFadingSunStaysWhereItIs) {
    const Sun sun = sunAt(40, {4, 3, 2}, 0.02f);
    const SkyAndSuns a(1, {sun}), b(1, {});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend blend({.seconds = 1, .sun_time = 0.1});
    blend.advance(lights, 5, 0, 0);
    float last = sun.irradiance.x;
    for (int i = 0; i < 40; ++i) {
        blend.advance(lights, 5, 1, 0.02);
        const LightView light = blend.light();
        ASSERT_LE(light.suns.size(), 1u);
        if (light.suns.empty()) continue;
        EXPECT_GT(dot(light.suns[0].direction, sun.direction), std::cos(0.2f * float(kDegree))) << i;
        EXPECT_NEAR(light.suns[0].radius, 0.02f, 1e-3f);
        EXPECT_LT(light.suns[0].irradiance.x, 1.01f * last);
        last = light.suns[0].irradiance.x;
    }
    EXPECT_LT(last, 1);
}

// Where one light has fewer bands, its suns have no part in the others. Windowed bands have as much of the suns as the
// window leaves. So the remainder of either end is the sky alone.
TEST(LightBlend, LightsOfOtherOrdersAndWindowsMix) {
    const SkyAndSuns a(1, {sunAt(20, {4, 4, 4})}, 4),
        b(1, {sunAt(20, {4, 4, 4})}, 6, {1, 0.9f, 0.8f, 0.6f, 0.4f, 0.2f});
    const std::array<LightView, 2> lights = {a, b};
    LightBlend blend({.seconds = 1, .sun_time = 0.1});
    blend.advance(lights, 6, 0, 0);
    for (const double t : {0.0, 1.0}) {
        blend.advance(lights, 6, 1, t);
        const LightView light = blend.light();
        ASSERT_EQ(light.order, 6);
        ASSERT_EQ(light.suns.size(), 1u);
        std::vector<float> soft(light.sh.begin(), light.sh.end());
        const Sun stored = sunAt(20, {4, 4, 4});
        subtractSuns({&stored, 1}, light.window, soft);
        for (std::size_t i = 3; i < soft.size(); ++i) EXPECT_NEAR(soft[i], 0, 1e-5f) << t << " " << i;
    }
}

TEST(LightBlend, IsNotWhereItIsNotWanted) {
    const SkyAndSuns a(1, {}), b(2, {}), c(2, {sunAt(10, {1, 1, 1})});
    const std::array<LightView, 3> lights = {a, b, c};
    LightBlend blend({.seconds = 0});
    blend.advance(lights, 5, 0, 0.02);
    blend.advance(lights, 5, 1, 0.02);
    EXPECT_FALSE(blend.active()) << "0 seconds are at once";
    LightBlend forms({.seconds = 1});
    forms.advance(lights, 5, 0, 0.02);
    forms.advance(lights, 5, 1, 0.02);
    EXPECT_TRUE(forms.active());
    EXPECT_FALSE(forms.hasSuns()) << "neither light has any, so none is made up";
    EXPECT_TRUE(forms.light().suns.empty());
    const std::uint64_t version = forms.version();
    forms.jump(1);
    EXPECT_FALSE(forms.active());
    EXPECT_GT(forms.version(), version);
    forms.advance(lights, 5, 2, 0.02);
    EXPECT_TRUE(forms.hasSuns());
    for (const double wrong : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(LightBlend({.seconds = wrong}), std::invalid_argument);
        EXPECT_THROW(LightBlend({.sun_time = wrong}), std::invalid_argument);
    }
}

}  // namespace
}  // namespace penumbra::test_light_blend
