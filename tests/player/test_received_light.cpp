// Light that a level ground and other members send to vertices, against sums over what sends it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "player/scene/emitter_kernel.h"
#include "player/scene/ground_glow.h"
#include "player/scene/received_light.h"
#include "sh/quadrature.h"
#include "tests/difference.h"

namespace penumbra::test_received_light {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Weights under which irradiance is pi E.
GroundWeights whiteWeights() {
    std::array<float, kFarCoefficients> ambient;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), ambient);
    GroundWeights weights;
    for (std::size_t i = 0; i < kFarCoefficients; ++i)
        weights[i] = Vec3d{1, 1, 1} * (std::numbers::pi * double(ambient[i]));
    return weights;
}

TEST(GroundGlow, HasTheRadianceOfFreeSightWhereNobodyCasts) {
    GroundGlow glow;
    const std::array corners{Vec3{-0.3f, 0.5f, -0.3f}, Vec3{0.3f, 2.3f, 0.3f}};
    glow.cast(CastShadow({}), 0.5, corners, 1);
    glow.light(whiteWeights(), {0.5f, 0.25f, 0});
    for (const Vec3 normal : {Vec3{0, -1, 0}, Vec3{1, 0, 0}}) {
        const Vec3 radiance = glow.radianceAt({0.1f, 1, 0}, normal);
        EXPECT_NEAR(radiance.x, 0.5f, 1e-3f);
        EXPECT_NEAR(radiance.y, 0.25f, 1e-3f);
        EXPECT_EQ(radiance.z, 0);
    }
}

// A square that faces a point is seen as bright as it is, and one that faces away not at all.
TEST(ReceivedLight, MeanRadianceIsThatOfWhatFacesThePoint) {
    std::vector<ShiningVertex> vertices;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j) {
            const float y = 0.1f * float(i) - 1, z = 0.1f * float(j) - 1;
            vertices.push_back({{1, y, z}, {-0.01f, 0, 0}, {0.4f, 0.2f, 0.1f}});
            vertices.push_back({{1.1f, y, z}, {0.01f, 0, 0}, {9, 9, 9}});
        }
    std::vector<Emitter> emitters;
    emittersOf(vertices, 0.5f, emitters);
    const Vec3 mean = meanRadiance(emitters, {0, 0, 0}, {1, 0, 0});
    EXPECT_NEAR(mean.x, 0.4f, 1e-4f);
    EXPECT_NEAR(mean.z, 0.1f, 1e-4f);
    EXPECT_EQ(meanRadiance(emitters, {0, 0, 0}, {-1, 0, 0}), (Vec3{}));
}

// The lanes, whose last block is not full, against one point at a time. Measured: 1.2e-7.
TEST(ReceivedLight, ManyPointsSeeWhatEachOfThemSees) {
    std::vector<Emitter> emitters;
    for (int e = 0; e < 50; ++e) {
        const float a = 0.7f * float(e);
        emitters.push_back({{std::cos(a), 0.05f * float(e) - 1, std::sin(a)},
                            {-0.02f * std::cos(a), 0.01f * std::sin(3 * a), -0.02f * std::sin(a)},
                            {0.5f + 0.4f * std::sin(a), 0.3f, 0.02f * float(e)}});
    }
    std::vector<Vec3> points, normals;
    for (int p = 0; p < 21; ++p) {
        const float a = 0.3f * float(p);
        points.push_back({0.3f * std::sin(a), 0.1f * float(p) - 1, 0.2f * std::cos(a)});
        normals.push_back({std::cos(a), 0, std::sin(a)});
    }
    normals.back() = {0, 1, 0};
    points.back() = {0, 9, 0};  // sees nobody
    std::vector<Vec3> expected;
    for (std::size_t p = 0; p < points.size(); ++p) expected.push_back(meanRadiance(emitters, points[p], normals[p]));
    for (const EmitterPath& path : pathsOf<EmitterPath>()) {
        std::vector<Vec3> means(points.size());
        path.mean(emitters.data(), emitters.size(), {points.data(), normals.data(), points.size()}, means.data());
        EXPECT_LT(largestDifference(means, expected), 1e-5);
        EXPECT_EQ(means.back(), (Vec3{}));
    }
}

TEST(ReceivedLight, OfTheGroundIsWhatItHidesTimesItsRadiance) {
    GroundGlow glow;
    const std::array corners{Vec3{-0.3f, 0, -0.3f}, Vec3{0.3f, 1.8f, 0.3f}};
    glow.cast(CastShadow({}), 0, corners, 1);
    glow.light(whiteWeights(), {0.5f, 0.5f, 0.5f});
    FrameVertices vertices;
    vertices.positions = {{0, 1, 0}, {0, 1, 0}};
    vertices.normals = {{0, -1, 0}, {0, 1, 0}};
    const HiddenSky hidden{{}, {0.8f, 0}};
    receiveFromGround(glow, hidden, 1, vertices);
    ASSERT_EQ(vertices.received.size(), 2u);
    EXPECT_NEAR(vertices.received[0].x, kPi * 0.8f * 0.5f, 2e-3f);
    EXPECT_EQ(vertices.received[1], (Vec3{}));
}

}  // namespace
}  // namespace penumbra::test_received_light
