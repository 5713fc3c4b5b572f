// Several maps of a sun, around who stands on a wide ground.
#include <gtest/gtest.h>

#include <limits>

#include "tests/difference.h"
#include "tests/runtime/sun_scenes.h"

namespace penumbra::test_sun_nest {
namespace {

using player_test::sunGround;
using player_test::SunMesh;
using player_test::sunNestOf;

constexpr float kDegree = float(std::numbers::pi / 180), kRadius = 0.27f * kDegree;
constexpr Vec3 kUp{0, 0, 1};

Vec3 sunAt(float elevation_degrees, float azimuth_degrees = 0) {
    const float e = elevation_degrees * kDegree, a = azimuth_degrees * kDegree;
    return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

// Half a metre wide, 1.8 m high.
SunMesh manAt(float x, float y, float z = 0) {
    return player_test::sunBox({x - 0.25f, y - 0.15f, z}, {x + 0.25f, y + 0.15f, z + 1.8f});
}

SunMaps mapsOf(const SunCasters& casters, Vec3 direction, float radius = kRadius) {
    SunMaps maps;
    maps.begin(casters, direction, radius);
    maps.draw(casters);
    return maps;
}

TEST(SunNest, HasOneMapWhereThatIsFineEnoughOrNoGroundCasts) {
    const SunMesh man = manAt(1, 0.5f), other = manAt(300, 40);
    for (const float elevation : {3.0f, 30.0f, 60.0f, 90.0f})
        for (const float azimuth : {0.0f, 31.0f, 45.0f}) {
            const Vec3 sun = sunAt(elevation, azimuth);
            const SunMesh eight_metres = sunGround(8, 17);
            const SunCasters narrow{{man}, eight_metres}, crowd{{man, other}};
            for (const SunCasters* casters : {&narrow, &crowd}) {
                const SunNest nest = sunNestOf(*casters, sun, kRadius);
                ASSERT_EQ(nest.maps.size(), 1u) << elevation;
                std::vector<SunCaster> all = casters->members;
                all.push_back(casters->ground);
                const SunFrame frame = fitSunFrame(all, sun, kRadius);
                EXPECT_EQ(nest.maps[0].frame.rows, frame.rows);
                EXPECT_EQ(nest.maps[0].frame.texel, frame.texel);
                EXPECT_EQ(nest.maps[0].frame.range, frame.range);
                EXPECT_EQ(nest.maps[0].weight({1e6f, 0, 0}), 1);
            }
            EXPECT_EQ(sunNestOf({{man}, sunGround(8, 17)}, sun, kRadius, 256).maps.size(), 2u) << "in a coarse map";
        }
    const SunMesh wide = sunGround(500, 5);
    EXPECT_EQ(sunNestOf({{}, wide}, kUp, kRadius).maps.size(), 1u) << "nobody stands there";
    EXPECT_TRUE(sunNestOf({}, kUp, kRadius).maps.empty());
    EXPECT_TRUE(sunNestOf({{man}, wide}, {}, kRadius).maps.empty());
    EXPECT_EQ(mapsOf({}, kUp).visibility({1, 2, 3}, kUp), 1);
}

// Wherever the sun is, a man and his shadow on level ground are in the finest map and nowhere near its border, and
// texels grow from map to map. Measured: texels of 1.0 to 3.1 mm.
TEST(SunNest, HoldsAManAndHisShadowInItsFinestMap) {
    Largest coarsest;
    for (const float side : {32.0f, 500.0f, 5000.0f})
        for (const float elevation : {8.0f, 30.0f, 60.0f, 90.0f})
            for (const float azimuth : {0.0f, 31.0f}) {
                const Vec3 sun = sunAt(elevation, azimuth);
                const SunMesh man = manAt(0.3f * side, 0.1f * side), ground = sunGround(side, 33);
                const SunNest nest = sunNestOf({{man}, ground}, sun, kRadius);
                ASSERT_GE(nest.maps.size(), 2u);
                coarsest.add(nest.maps[0].frame.texel);
                for (const Vec3 p : man.positions) {
                    EXPECT_EQ(nest.maps[0].weight(p), 1) << side << " " << elevation;
                    EXPECT_EQ(nest.maps[0].weight(p - sun * (p.z / sun.z)), 1) << side << " " << elevation;
                }
                for (std::size_t i = 1; i < nest.maps.size(); ++i) {
                    EXPECT_GE(nest.maps[i].frame.texel, 2 * nest.maps[i - 1].frame.texel);
                    EXPECT_EQ(nest.maps[i].whole_ground, i + 1 == nest.maps.size());
                }
                EXPECT_EQ(nest.maps.back().weight({0, 0, 0}), 1);
            }
    EXPECT_LT(coarsest, 0.0035f);
}

// The ground along the shadow's edges, a millimetre a step: where visibility passes one half, and what it is in the
// umbra and beside the shadow. The man's edges lie at y = +-0.15.
TEST(SunMaps, AManHasTheSameShadowOnEveryGround) {
    for (const float side : {32.0f, 500.0f, 5000.0f})
        for (const float elevation : {8.0f, 30.0f, 60.0f}) {
            const Vec3 at{std::round(0.3f * side), std::round(-0.2f * side), 0}, sun = sunAt(elevation);
            const SunMesh man = manAt(at.x, at.y), ground = sunGround(side, 33);
            const SunMaps maps = mapsOf({{man}, ground}, sun);
            const float x = at.x - 0.25f - 0.5f / std::tan(elevation * kDegree);  // shadow of an object 0.5 m high
            for (const float to : {-1.0f, 1.0f}) {
                const auto seen = [&](float y) { return maps.visibility({x, at.y + to * y, 0}, kUp); };
                EXPECT_EQ(seen(0.05f), 0) << side << " " << elevation;
                EXPECT_EQ(seen(0.3f), 1) << side << " " << elevation;
                float edge = 0.05f;
                while (edge < 0.3f && seen(edge) < 0.5f) edge += 0.001f;
                EXPECT_NEAR(edge, 0.15f, 0.006f) << side << " " << elevation;
            }
        }
}

// Points on a line from the man to the edge of the ground and beyond it, at every distance: no acne where the ground
// is lit, and the shadow of a wall of 40 m stays dark through all borders.
TEST(SunMaps, BordersHaveNoAcneAndNoLeaks) {
    std::size_t dark = 0, light = 0, lit_points = 0, shadowed = 0;
    for (const float side : {32.0f, 500.0f, 5000.0f})
        for (const float elevation : {8.0f, 25.0f, 60.0f, 90.0f})
            for (const float azimuth : {0.0f, 31.0f}) {
                const Vec3 sun = sunAt(elevation, azimuth);
                const SunMesh man = manAt(0, 0), plain = sunGround(side, 65);
                const SunMaps maps = mapsOf({{man}, plain}, sun);
                for (float r = 1; r < side / 2; r *= 1.003f)
                    for (const float turn : {-60.0f, 0.0f, 45.0f}) {  // on the side of the sun
                        const float a = (azimuth + turn) * kDegree;
                        dark += maps.visibility({r * std::cos(a), r * std::sin(a), 0}, kUp) != 1;
                        ++lit_points;
                    }
                if (elevation > 45) continue;
                SunMesh walled = plain;  // along the border, on the side of the sun
                const float height = 0.1f * side;
                for (Vec3& p : walled.positions)
                    if (p.x > 0.499f * side) p.z = height;
                const SunMaps in_shadow = mapsOf({{man}, walled}, sun);
                const float reach = height / std::tan(elevation * kDegree) * std::cos(azimuth * kDegree);
                // It begins where the wall's slope ends, and ends before the penumbra.
                const float slope = side / 64, last = std::max(0.5f * side - 0.9f * reach, -0.4f * side);
                for (float x = 0.5f * side - 1.5f * slope; x > last; x -= 0.001f * side) {
                    light += !(in_shadow.visibility({x, 0.7f, 0}, kUp) <= 0.02f);
                    ++shadowed;
                }
            }
    EXPECT_EQ(dark, 0u) << "of " << lit_points;
    EXPECT_EQ(light, 0u) << "of " << shadowed;
    EXPECT_GT(shadowed, 2000u);
}

// Visibility changes little from one millimetre to the next, so no border shows on waves that shadow themselves.
TEST(SunMaps, BordersAreSmoothOnWaves) {
    const SunMesh man = manAt(0, 0, 0.5f);
    const SunMesh waves = sunGround(500, 257, [](float x, float y) { return 2 * std::sin(0.11f * x + 0.05f * y); });
    const SunCasters casters{{man}, waves};
    const Vec3 sun = sunAt(12, 20);
    const SunMaps maps = mapsOf(casters, sun);
    ASSERT_GE(maps.maps().size(), 3u);
    std::size_t both = 0;
    for (const float y : {-3.0f, 1.1f, 7.0f, 40.0f}) {
        for (float x = -60; x < 60; x += 0.01f) {
            const Vec3 p{x, y, 2 * std::sin(0.11f * x + 0.05f * y)};
            const float w = maps.nest().maps[0].weight(p);
            both += w > 0 && w < 1;
            EXPECT_NEAR(maps.nest().maps[0].weight({x + 0.001f, p.y, p.z}), w, 0.05f) << x << " " << y;
        }
    }
    EXPECT_GT(both, 5u);
}

TEST(SunNest, MembersFarApartHaveMapsOfTheirOwn) {
    const SunMesh ground = sunGround(1000, 33);
    const SunMesh men[] = {manAt(-200, 300), manAt(-201, 301), manAt(250, -100), manAt(0, 0), manAt(400, 400)};
    const Vec3 sun = sunAt(40, 20);
    const auto nestOf = [&](std::size_t count) {
        return sunNestOf({{std::begin(men), std::begin(men) + std::ptrdiff_t(count)}, ground}, sun, kRadius);
    };
    for (const auto& [count, groups] : {std::pair(std::size_t(2), 1u), {3, 2}, {4, 3}}) {
        const SunNest nest = nestOf(count);
        for (std::size_t m = 0; m < count; ++m) {
            std::size_t fine = 0;
            for (unsigned g = 0; g < groups; ++g) {
                const NestedSunMap& map = nest.maps[g];
                fine += map.frame.texel < 0.006f && map.weight(men[m].positions[7]) == 1;
            }
            EXPECT_EQ(fine, 1u) << m << " of " << count;
        }
        EXPECT_GT(nest.maps[groups].frame.texel, 0.008f);
    }
    EXPECT_EQ(nestOf(5).maps.size(), nestOf(4).maps.size() + 1);
    // Each casts its own shadow, and none on the other.
    const SunCasters two{{men[0], men[2]}, ground};
    const SunMaps maps = mapsOf(two, sun);
    for (const SunMesh* man : {&men[0], &men[2]}) {
        const Vec3 middle = (man->positions[0] + man->positions[7]) * 0.5f;
        EXPECT_EQ(maps.visibility(middle - sun * (middle.z / sun.z), kUp), 0);
        EXPECT_EQ(maps.visibility(middle - sun * (middle.z / sun.z) + Vec3{0, 1.5f, 0}, kUp), 1);
    }
}

// Men in a row that no cut halves, in a triangle, and more of them than there are maps: whoever is in the picture has a
// shadow, a sharp one or at least that of a coarse map.
TEST(SunMaps, NobodyLosesTheShadowToOthers) {
    const SunMesh ground = sunGround(512, 33);
    const Vec3 sun = sunAt(40, 20);
    std::vector<std::vector<SunMesh>> crowds = {
        {manAt(0, 0), manAt(100, 0), manAt(200, 0)},
        {manAt(0, 0), manAt(100, 0), manAt(50, 87)},
        {manAt(0, 0), manAt(100, 0), manAt(0, 100), manAt(100, 100)},
        {manAt(0, 0), manAt(130, 20), manAt(-90, 60), manAt(40, -110), manAt(-20, 140)},
        {}};
    for (int i = 0; i < 12; ++i)
        crowds.back().push_back(manAt(float(i * 7919 % 400) - 200, float(i * 104729 % 397) - 200));
    for (const std::vector<SunMesh>& men : crowds) {
        const SunCasters casters{{men.begin(), men.end()}, ground};
        const SunNest nest = sunNestOf(casters, sun, kRadius);
        std::size_t sharp = 0;
        for (std::uint32_t m = 0; m < men.size(); ++m) {
            bool fine = false, somewhere = false;
            for (const NestedSunMap& map : nest.maps) {
                const bool casts = std::ranges::find(map.members, m) != map.members.end();
                somewhere |= casts;
                fine |= casts && map.frame.texel < 0.006f && map.weight(men[m].positions[7]) == 1;
            }
            EXPECT_TRUE(somewhere) << m << " of " << men.size();
            sharp += fine;
        }
        EXPECT_GE(sharp, men.size() <= std::size_t(kMaxSunGroups) ? men.size() : 1u) << men.size();
    }
}

// A crowd on a wide ground, and props of all sizes beside it.
TEST(SunNest, NeverHasMoreMapsThanThereIsRoomFor) {
    std::vector<SunMesh> meshes;
    for (int i = 0; i < 200; ++i) {
        const float x = float(i * 7919 % 1000) - 500, y = float(i * 104729 % 997) - 500, s = i % 5 == 0 ? 0.05f : 1.0f;
        meshes.push_back(player_test::sunBox({x, y, 0}, {x + s, y + s, 1.8f * s}));
    }
    for (const float side : {50.0f, 1e3f, 1e6f, 6.5e9f}) {
        const SunMesh ground = sunGround(side, 9);
        const SunCasters casters{{meshes.begin(), meshes.end()}, ground};
        for (const float elevation : {0.0f, 2.0f, 50.0f}) {
            const SunNest nest = sunNestOf(casters, sunAt(elevation), kRadius);
            ASSERT_TRUE(!nest.maps.empty() && nest.maps.size() <= std::size_t(kMaxNestedMaps)) << side;
            for (const NestedSunMap& map : nest.maps)
                EXPECT_TRUE(std::isfinite(map.frame.range) && map.frame.texel > 0) << side << " " << elevation;
        }
    }
}

// Below a man lie triangles of up to 1,000,000 km. Where floats do not tell places on them from one another, and where
// areas in texels would leave 64 bits, maps are coarser.
TEST(SunMaps, RubbishAndHugeTrianglesAreDefined) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const SunMesh man = manAt(0, 0);
    for (const float side : {1e3f, 1e4f, 1e5f, 1e6f, 1e9f}) {
        const SunMesh huge = sunGround(side, 2);
        for (const float elevation : {20.0f, 45.0f, 90.0f}) {
            const SunMaps maps = mapsOf({{man}, huge}, sunAt(elevation, 20));
            std::size_t dark = 0;
            for (float x = 0.7f; x < 0.4f * side; x *= 1.01f)
                for (const float y : {-0.3f, 0.0f, 0.2f}) dark += maps.visibility({x, x * y, 0}, kUp) != 1;
            EXPECT_EQ(dark, 0u) << side << " " << elevation;
            if (side > 1e4f || elevation > 45) continue;
            EXPECT_EQ(maps.visibility(Vec3{0, 0, 0.9f} - sunAt(elevation, 20) * (0.9f / sunAt(elevation).z), kUp), 0)
                << side << " " << elevation;
        }
    }
    SunMesh ground = sunGround(500, 33);
    ground.positions[5].x = nan;
    ground.positions[40].z = inf;
    ground.positions[16 * 33 + 16].y = -inf;  // below the man
    SunMesh broken = man;
    for (Vec3& p : broken.positions) p.y = nan;
    const SunMaps maps = mapsOf({{broken, man}, ground}, sunAt(45));
    EXPECT_EQ(maps.visibility({-0.7f, 0, 0}, kUp), 0);
    EXPECT_EQ(maps.visibility({nan, 0, 0}, kUp), 0);
    EXPECT_EQ(maps.visibility({0, 0, 0}, {nan, 0, 0}), 0);
    EXPECT_EQ(maps.visibility({1e30f, -1e30f, 0}, kUp), 1);
    EXPECT_EQ(sunNestOf({{broken}, ground}, kUp, kRadius).maps.size(), 1u);
    for (Vec3& p : ground.positions) p.x = nan;
    EXPECT_EQ(mapsOf({{man}, ground}, sunAt(45)).visibility({-0.7f, 0, 0}, kUp), 0);
    for (const float radius : {nan, -1.0f, inf, 100.0f}) {
        const float v = mapsOf({{man}, sunGround(500, 9)}, sunAt(45), radius).visibility({-0.7f, 0, 0}, kUp);
        EXPECT_TRUE(v >= 0 && v <= 1) << radius;
    }
}

TEST(SunMaps, DrawTheSameInParts) {
    const SunMesh man = manAt(1, 2), ground = sunGround(500, 33);
    const SunCasters casters{{man}, ground};
    const SunMaps whole = mapsOf(casters, sunAt(30));
    SunMaps parts;
    parts.begin(casters, sunAt(30), kRadius);
    for (const int band : {4, 0, 2, 1, 3}) parts.draw(casters, band, 5);
    for (std::size_t i = 0; i < whole.maps().size(); ++i)
        EXPECT_TRUE(std::ranges::equal(whole.maps()[i].depths(), parts.maps()[i].depths())) << i;
}

}  // namespace
}  // namespace penumbra::test_sun_nest
