// Lights of rooms in pictures that the tests paint: a dim sky over a dark floor, with discs.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "formats/image/area_lights.h"
#include "sh/angles.h"
#include "sh/sh_basis.h"
#include "tests/difference.h"

namespace penumbra::test_area_lights {
namespace {

using std::numbers::pi;

struct Disc {
    Vec3d direction;
    double radius = 0;      // degrees
    double irradiance = 1;  // irradiance of red; green has 0.8 and blue 0.6 of it
};

EnvironmentMap roomWith(const std::vector<Disc>& discs, int width = 192) {
    EnvironmentMap map;
    map.image = {width, width / 2, std::vector<Vec3>(std::size_t(width) * std::size_t(width / 2)), {}};
    const auto forEachPixel = [&](const auto& visit) {
        for (int y = 0; y < width / 2; ++y)
            for (int x = 0; x < width; ++x)
                visit(mapDirection(map.shape(), x + 0.5, y + 0.5), mapSteradians(map.shape(), x + 0.5, y + 0.5),
                      map.image.pixels[std::size_t(y * width + x)]);
    };
    forEachPixel([](Vec3d d, double, Vec3& rgb) { rgb = toFloat((d.y > 0 ? 0.3 : 0.1) * Vec3d{0.9, 1, 1.1}); });
    for (const Disc& disc : discs) {
        // A soft rim, two pixels wide, so that nothing depends on which centers it holds.
        const auto cover = [&](Vec3d d) {
            const double angle = std::atan2(length(cross(d, disc.direction)), dot(d, disc.direction));
            return std::clamp((radians(disc.radius) - angle) * width / (4 * pi) + 0.5, 0.0, 1.0);
        };
        double area = 0;
        forEachPixel([&](Vec3d d, double steradians, Vec3&) { area += cover(d) * steradians; });
        forEachPixel([&](Vec3d d, double, Vec3& rgb) {
            rgb += toFloat(disc.irradiance * cover(d) / area * Vec3d{1, 0.8, 0.6});
        });
    }
    return map;
}

Vec3d towards(double elevation, double azimuth) {
    const double e = radians(elevation), a = radians(azimuth);
    return {std::cos(e) * std::cos(a), std::sin(e), std::cos(e) * std::sin(a)};
}

double degreesBetween(Vec3d a, Vec3d b) { return degrees(std::atan2(length(cross(a, b)), dot(a, b))); }

Vec3d fluxOf(const EnvironmentMap& map) {
    Vec3d flux;
    for (int y = 0; y < map.image.height; ++y)
        for (int x = 0; x < map.image.width; ++x)
            flux += mapSteradians(map.shape(), x + 0.5, y + 0.5) *
                    toDouble(map.image.pixels[std::size_t(y * map.image.width + x)]);
    return flux;
}

// Two lamps 20 degrees apart, which SH of order 6 cannot tell apart, a window and a lamp on the other side. Measured
// within 0.9 degrees, 1.6 degrees of radius and 6% of irradiance.
TEST(AreaLights, FindsLampsAndAWindow) {
    const std::vector<Disc> truth = {
        {towards(50, 0), 4, 1}, {towards(50, 31), 3, 0.8}, {towards(30, 150), 12, 2}, {towards(70, -100), 6, 0.7}};
    const AreaLights found = findAreaLights(roomWith(truth), 8);
    ASSERT_EQ(found.lights.size(), truth.size());
    for (const Disc& disc : truth) {
        const AreaLight* nearest = &found.lights[0];
        for (const AreaLight& light : found.lights)
            if (dot(light.sun.direction, disc.direction) > dot(nearest->sun.direction, disc.direction))
                nearest = &light;
        EXPECT_LT(degreesBetween(nearest->sun.direction, disc.direction), 1.5) << disc.radius;
        EXPECT_NEAR(degrees(nearest->sun.radius), disc.radius, 2.5);
        EXPECT_NEAR(nearest->sun.irradiance.x, disc.irradiance, 0.12 * disc.irradiance) << disc.radius;
        EXPECT_NEAR(nearest->sun.irradiance.z, 0.6 * nearest->sun.irradiance.x, 0.05 * disc.irradiance);
        EXPECT_EQ(nearest->share, 1);
    }
}

TEST(AreaLights, LightsAndRestAreThePicture) {
    const EnvironmentMap room = roomWith({{towards(50, 0), 4, 1}, {towards(50, 25), 3, 0.8}, {towards(20, 90), 20, 3}});
    for (int most = 1; most <= kMaxSuns; ++most) {
        const AreaLights found = findAreaLights(room, most);
        EXPECT_LE(found.lights.size(), std::size_t(most));
        Vec3d sum = fluxOf(found.rest);
        for (const AreaLight& light : found.lights) sum += light.sun.irradiance;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], fluxOf(room)[c], 1e-5 * fluxOf(room)[c]) << most;
        for (const Vec3& rgb : found.rest.image.pixels) ASSERT_TRUE(rgb.x >= 0 && rgb.y >= 0 && rgb.z >= 0);
    }
}

TEST(AreaLights, EvenLightAndBlackHaveNone) {
    EXPECT_TRUE(findAreaLights(roomWith({}), 8).lights.empty());
    EnvironmentMap black = roomWith({});
    for (Vec3& rgb : black.image.pixels) rgb = {};
    EXPECT_TRUE(findAreaLights(black, 8).lights.empty());
}

TEST(AreaLights, ASunInASkyIsTheOnlyOne) {
    const Vec3d sun = towards(40, 20);
    const AreaLights found = findAreaLights(roomWith({{sun, 1.9, 6}}), 8);
    ASSERT_EQ(found.lights.size(), 1u);
    EXPECT_LT(degreesBetween(found.lights[0].sun.direction, sun), 0.5);
    EXPECT_NEAR(found.lights[0].sun.irradiance.x, 6, 0.4);
}

// SH of order 6 of the lights as discs. Bands of a disc fall about as exp(-l (l + 1) radius^2 / 8).
std::array<double, 3 * 36> shOf(const AreaLights& found) {
    std::array<double, 3 * 36> sh{};
    std::array<double, 36> basis;
    for (const AreaLight& light : found.lights) {
        evalBasis(6, light.sun.direction, std::span<double>(basis));
        for (std::size_t i = 0; i < 36; ++i) {
            const double l = bandOfIndex(int(i));
            for (std::size_t c = 0; c < 3; ++c)
                sh[3 * i + c] += basis[i] * std::exp(-l * (l + 1) * light.sun.radius * light.sun.radius / 8) *
                                 light.sun.irradiance[int(c)];
        }
    }
    return sh;
}

// Largest step of the lights along 51 rooms, as a part of the largest length of them.
double largestStep(int most, const std::function<EnvironmentMap(double)>& room) {
    Largest step, largest;
    std::array<double, 108> last{};
    for (int i = 0; i <= 50; ++i) {
        const std::array<double, 108> now = shOf(findAreaLights(room(i / 50.0), most));
        if (i > 0) step.add(distanceBetween(now, last));
        largest.add(distanceBetween(now, std::array<double, 108>{}));
        last = now;
    }
    return step / largest;
}

// The sweeps of the table in docs/formulas.md, section 11, and one of a room, in five times its steps. Measured .02,
// .009, .034, .17 and .09; a lamp that moves by the steps of the last sweep and stays the same makes .05 of these.
void expectSmooth(double bound, const std::function<EnvironmentMap(double)>& room) {
    for (const int most : {2, 8}) {
        const double step = largestStep(most, room);
        std::printf("%d lights at most: largest step %.4f\n", most, step);
        EXPECT_LT(step, bound) << most;
    }
}

const Vec3d kFirst = towards(45, 10), kSecond = towards(30, 130), kThird = towards(60, -90);

TEST(AreaLights, ALampThatFadesIsContinuous) {
    expectSmooth(0.05, [](double t) { return roomWith({{kFirst, 3, 5 * (1 - t)}}, 128); });
}

TEST(AreaLights, TwoThatChangeRanksAreContinuous) {
    expectSmooth(0.05, [](double t) { return roomWith({{kFirst, 3, 5 - 2 * t}, {kSecond, 4, 3 + 2 * t}}, 128); });
}

TEST(AreaLights, ThreeThatChangeRanksAreContinuous) {
    expectSmooth(0.05, [](double t) {
        return roomWith({{kFirst, 3, 5 - 2 * t}, {kSecond, 4, 4}, {kThird, 4, 3 + 2 * t}}, 128);
    });
}

TEST(AreaLights, ASettingSunIsContinuous) {
    expectSmooth(0.2, [](double t) { return roomWith({{towards(45 - 60 * t, 10), 3, 4}}, 128); });
}

TEST(AreaLights, LampsThatMeetAreContinuous) {
    expectSmooth(0.12, [](double t) { return roomWith({{towards(45, 40 * t), 4, 3}, {towards(45, 40), 4, 2}}, 128); });
}

}  // namespace
}  // namespace penumbra::test_area_lights
