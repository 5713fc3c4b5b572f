#include <gtest/gtest.h>

#include <limits>

#include "tests/runtime/sun_scenes.h"

namespace penumbra::test_sun_map {
namespace {

using player_test::SunMesh;

constexpr float kDegree = float(std::numbers::pi / 180);
constexpr Vec3 kUp{0, 0, 1};

Vec3 sunAt(float elevation_degrees, float azimuth_degrees) {
    const float e = elevation_degrees * kDegree, a = azimuth_degrees * kDegree;
    return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

struct EdgeProfile {
    double place = 0, width = 0;  // where visibility passes one half; width of a linear ramp of the same spread
};

// Goes along the ground from the umbra (0) to the light (`length`).
EdgeProfile profileAlong(const SunMap& map, Vec3 from, Vec3 direction, double length) {
    constexpr int kSteps = 4000;
    double mean = 0, square = 0, sum = 0, last = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double s = length * i / kSteps;
        const double v = double(map.visibility(from + direction * float(s), kUp));
        const double step = std::max(v - last, 0.0);
        last = std::max(v, last);
        sum += step;
        mean += step * s;
        square += step * s * s;
    }
    mean /= sum;
    return {mean, std::sqrt(12 * std::max(square / sum - mean * mean, 0.0))};
}

// A bar above the ground z = 0, along y. Seen from a sun above, its edge x = half casts its edge there; the profile of
// a disc of radius R has the spread of a ramp of width sqrt(3) R.
TEST(SunMap, EdgesAndPenumbrasOfABarAreThoseOfADisc) {
    for (const float height : {0.1f, 0.3f, 1.0f})
        for (const float radius : {0.0f, 0.27f * kDegree, 1 * kDegree, 3 * kDegree, 6 * kDegree}) {
            const SunMesh bar = player_test::sunBox({-0.3f, -1, height}, {0.3f, 1, height + 0.002f});
            const SunMesh far_box = player_test::sunBox({-1, -0.1f, 0}, {-0.9f, 0, 1.5f});
            const SunCaster casters[] = {bar, far_box};
            const SunMap map = player_test::sunMapOf(casters, kUp, radius);
            const double penumbra = double(height) * std::tan(double(radius));
            const double texel = double(map.frame().texel);
            const EdgeProfile edge = profileAlong(map, {0, 0.3f, 0}, {1, 0, 0}, 1);
            EXPECT_NEAR(edge.place, 0.3, 1.5 * texel) << height << " " << radius;
            const double expected = std::max(std::sqrt(3.0) * penumbra, texel);
            EXPECT_NEAR(edge.width, expected, 0.2 * expected + (penumbra < texel ? texel : 0))
                << height << " " << radius;
        }
}

// The slopes of a valley rise above the plane of its floor, but stand nowhere before the disc of a wide sun. Without
// what SunMap looks through first, a box as wide as the far caster says, floors were dark in patches.
TEST(SunMap, FloorsOfValleysAreLitByAWideSun) {
    const SunMesh valley = player_test::sunGround(4, 65, [](float x, float y) { return 0.1f * (x * x + y * y); });
    const SunMesh far_box = player_test::sunBox({-1.9f, -1.9f, 3}, {-1.8f, -1.8f, 3.1f});
    const SunCaster casters[] = {valley, far_box};
    for (const float elevation : {30.0f, 60.0f, 90.0f}) {
        const SunMap map = player_test::sunMapOf(casters, sunAt(elevation, 200), 7 * kDegree);
        for (std::size_t v = 0; v < valley.positions.size(); v += 7) {
            const Vec3 p = valley.positions[v];
            if (p.x * p.x + p.y * p.y > 0.5f) continue;
            EXPECT_GT(map.visibility(p, normalized(Vec3{-0.2f * p.x, -0.2f * p.y, 1})), 0.98f) << elevation;
        }
    }
}

TEST(SunMap, LitPlanesHaveNoAcne) {
    std::size_t wrong = 0, points = 0;
    for (const float elevation : {5.0f, 15.0f, 35.0f, 60.0f, 89.0f, 90.0f})
        for (const float azimuth : {0.0f, 17.0f, 45.0f, 133.0f, 270.0f})
            for (const float radius : {0.0f, 0.3f * kDegree, 4 * kDegree})
                for (const Vec3 normal : {kUp, Vec3{0.3f, 0.1f, 1}, Vec3{-0.5f, 0.5f, 1}}) {
                    const SunMesh square = player_test::sunSquare(normal, 1);
                    const SunCaster casters[] = {square};
                    const Vec3 sun = sunAt(elevation, azimuth);
                    const Vec3 n = normalized(normal);
                    if (dot(sun, n) < 0.03f) continue;
                    const SunMap map = player_test::sunMapOf(casters, sun, radius, 256);
                    const Vec3 a = square.positions[1] - square.positions[0],
                               b = square.positions[3] - square.positions[0];
                    for (int i = 1; i < 40; ++i)
                        for (int j = 1; j < 40; ++j, ++points)
                            wrong +=
                                map.visibility(square.positions[0] + a * (float(i) / 40) + b * (float(j) / 40), n) != 1;
                }
    EXPECT_EQ(wrong, 0u) << "of " << points;
}

// The half of a sphere that faces the sun is lit.
TEST(SunMap, SpheresHaveNoAcne) {
    std::size_t wrong = 0, points = 0;
    const SunMesh sphere = player_test::sunSphere(40), fine = player_test::sunSphere(150);
    const SunCaster casters[] = {sphere};
    for (const float radius : {0.0f, 0.5f * kDegree, 4 * kDegree})
        for (const float elevation : {3.0f, 40.0f, 90.0f}) {
            const Vec3 sun = sunAt(elevation, 31);
            const SunMap map = player_test::sunMapOf(casters, sun, radius);
            for (std::size_t t = 0; t < sphere.triangles.size(); t += 3)
                for (const Vec3 w : {Vec3{1, 1, 1}, Vec3{4, 1, 1}, Vec3{1, 9, 1}, Vec3{0, 1, 2}}) {
                    Vec3 p{};
                    for (int i = 0; i < 3; ++i) p += sphere.positions[sphere.triangles[t + std::size_t(i)]] * w[i];
                    p = p / (w.x + w.y + w.z);
                    const Vec3 n = normalized(p);
                    if (dot(n, sun) < 0.1f) continue;
                    ++points;
                    wrong += map.visibility(p, n) != 1;
                }
        }
    EXPECT_EQ(wrong, 0u) << "of " << points;
}

// A box stands on the ground; behind it no light gets between them.
TEST(SunMap, NoLightLeaksWhereABoxTouchesTheGround) {
    const SunMesh box = player_test::sunBox({-0.2f, -0.5f, 0}, {0.2f, 0.5f, 1});
    const SunMesh thin = player_test::sunBox({0, -0.5f, 0}, {0.01f, 0.5f, 1});
    std::size_t lit = 0, points = 0;
    for (const SunMesh* mesh : {&box, &thin})
        for (const float radius : {0.0f, 0.3f * kDegree, 2 * kDegree})
            for (const float elevation : {20.0f, 45.0f, 70.0f}) {
                const SunCaster casters[] = {*mesh};
                const SunMap map = player_test::sunMapOf(casters, sunAt(elevation, 180), radius);
                const float far_side = mesh->positions[1].x;
                for (float texels = 1.5f; texels < 10; texels += 0.25f)
                    for (int j = -30; j <= 30; ++j, ++points)
                        lit +=
                            map.visibility({far_side + texels * map.frame().texel, 0.01f * float(j), 0}, kUp) > 0.02f;
            }
    EXPECT_EQ(lit, 0u) << "of " << points;
}

TEST(SunMap, BothFacesOfASheetCast) {
    SunMesh sheet = player_test::sunSquare(kUp, 0.5f);
    for (Vec3& p : sheet.positions) p.z = 0.5f;
    const SunMesh one = sheet;
    std::vector<std::uint32_t> backs = sheet.triangles;
    for (std::size_t t = 0; t < backs.size(); t += 3) std::swap(backs[t], backs[t + 1]);
    for (const auto& triangles : {sheet.triangles, backs}) {
        const SunMesh mesh{sheet.positions, triangles};
        const SunCaster casters[] = {mesh};
        const SunMap map = player_test::sunMapOf(casters, kUp, 0.01f);
        EXPECT_EQ(map.visibility({0, 0, 0}, kUp), 0);
        EXPECT_EQ(map.visibility({0, 0, 0.5f}, kUp), 1);   // its own upper face
        EXPECT_EQ(map.visibility({0, 0, 0.5f}, -kUp), 0);  // faces away
        EXPECT_EQ(map.visibility({0.7f, 0, 0}, kUp), 1);
    }
}

// The grid of texels stays where it is, so a bar's shadow does too.
TEST(SunMap, EdgesStayWhileOtherCastersMoveByPartsOfATexel) {
    const SunMesh bar = player_test::sunBox({-0.31f, -1, 0.5f}, {0.3f, 1, 0.52f});
    const Vec3 sun = normalized(Vec3{0.3f, 0.2f, 1});
    std::vector<float> first;
    for (const float moved : {0.0f, 0.0003f, 0.0011f, 0.0026f}) {
        const SunMesh other = player_test::sunBox({-2.5f - moved, -1.2f - moved, 0}, {-2.4f, -1.1f, 0.6f + moved});
        const SunCaster casters[] = {bar, other};
        const SunMap map = player_test::sunMapOf(casters, sun, 0.01f);
        ASSERT_GT(map.frame().texel, 0.0026f);
        std::vector<float> seen;
        for (int i = 0; i < 500; ++i)
            seen.push_back(map.visibility({-0.6f + 0.002f * float(i), 0.001f * float(i), 0}, kUp));
        if (first.empty()) first = seen;
        for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(seen[i], first[i], 0.001f) << moved << " " << i;
    }
}

TEST(SunMap, DrawsTheSameInParts) {
    const SunMesh sphere = player_test::sunSphere(30);
    const SunCaster casters[] = {sphere};
    const SunMap whole = player_test::sunMapOf(casters, {1, 2, 3}, 0.01f, 256);
    SunMap parts;
    parts.begin(whole.frame());
    for (const auto& [first, last] : {std::pair(0, 100), {200, 256}, {100, 101}, {101, 200}})
        parts.draw(casters, first, last);
    EXPECT_TRUE(std::equal(whole.depths().begin(), whole.depths().end(), parts.depths().begin()));
}

TEST(SunMap, RubbishIsSkipped) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(player_test::sunMapOf({}, kUp, 0.01f).visibility({1, 2, 3}, kUp), 1);
    SunMesh mesh = player_test::sunBox({-1, -1, 1}, {1, 1, 2});
    const std::size_t whole = mesh.triangles.size();
    mesh.positions.insert(mesh.positions.end(), {{nan, 0, 0}, {0, inf, 0}});
    mesh.triangles.insert(mesh.triangles.end(), {8, 0, 1, 2, 9, 3, 0, 0, 1, 2, 2, 2});
    const SunCaster casters[] = {mesh};
    const SunMap map = player_test::sunMapOf(casters, kUp, 0.01f, 128);
    const SunCaster clean[] = {{mesh.positions, std::span(mesh.triangles).first(whole)}};
    const SunMap same = player_test::sunMapOf(clean, kUp, 0.01f, 128);
    EXPECT_TRUE(std::equal(map.depths().begin(), map.depths().end(), same.depths().begin()));
    EXPECT_EQ(map.visibility({0, 0, 0}, kUp), 0);
    EXPECT_EQ(map.visibility({nan, 0, 0}, kUp), 0);
    EXPECT_EQ(map.visibility({0, 0, 0}, {nan, 0, 0}), 0);
    EXPECT_EQ(map.visibility({0, 0, 0}, -kUp), 0);
    for (const Vec3 direction : {Vec3{}, Vec3{nan, 0, 0}, Vec3{inf, 0, 0}})
        EXPECT_EQ(fitSunFrame(casters, direction, 0.01f).size, 0);
    for (const float radius : {nan, -1.0f, inf, 100.0f}) {
        const float v = player_test::sunMapOf(casters, kUp, radius, 64).visibility({0, 0, 0}, kUp);
        EXPECT_TRUE(v >= 0 && v <= 1) << radius;
    }
    // From below the ground the sun meets the other side.
    EXPECT_EQ(player_test::sunMapOf(casters, -kUp, 0, 64).visibility({0, 0, 3}, -kUp), 0);
    const SunMesh point{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {0, 1, 2}};
    const SunCaster points[] = {point};
    EXPECT_EQ(player_test::sunMapOf(points, kUp, 0.01f, 64).visibility({0, 0, 0}, kUp), 1);
}

}  // namespace
}  // namespace penumbra::test_sun_map
