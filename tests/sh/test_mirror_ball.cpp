// Tests the mirror ball: goldens, two ways to the same angle, and places on the ground.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sh/light/mirror_ball.h"
#include "tests/difference.h"
#include "tests/sh/golden.h"

namespace penumbra::test_mirror_ball {
namespace {

using std::numbers::pi;

TEST(MirrorBall, AnglesAreTheGoldenOnes) {
    const nlohmann::json golden = readGolden("light_capture.json")["angles"];
    const double k = golden["k"];
    const std::vector<double> incidence = doubles(golden["i"]), theta = doubles(golden["theta"]),
                              omega = doubles(golden["omega"]);
    for (std::size_t j = 0; j < incidence.size(); ++j) {
        EXPECT_NEAR(lightAngle(incidence[j], k), theta[j], 1e-9);
        EXPECT_NEAR(steradiansPerArea(incidence[j], k) / omega[j], 1, 1e-8);  // k has 12 digits
        EXPECT_NEAR(incidenceOf(lightAngle(incidence[j], k), k), incidence[j], 1e-9);
    }
}

TEST(MirrorBall, ReflectedDirectionsAreTheGoldenOnes) {
    const nlohmann::json golden = readGolden("light_capture.json")["vectors"];
    for (const nlohmann::json& one : golden) {
        const std::optional<Vec3d> found = reflectedDirection({vec3(one["c"]), 1, 1}, {}, vec3(one["e"]));
        ASSERT_TRUE(found);
        EXPECT_LT(distanceBetween(*found, vec3(one["direction"])), 1e-9);
    }
    EXPECT_FALSE(reflectedDirection({{0, 0, 3}, 1, 1}, {}, {1, 0, 0}));   // passes by
    EXPECT_FALSE(reflectedDirection({{0, 0, 3}, 1, 1}, {}, {0, 0, -1}));  // looks away
}

// The solid angle of light by differences of the angle: d omega = sin t dt dq, and an image plane at distance 1 has
// tan b d(tan b) dq.
TEST(MirrorBall, SolidAnglesAreDifferencesOfAngles) {
    for (double k : {0.5, 0.1, 0.02})
        for (double i : {0.05, 0.7, 1.3}) {
            const auto tangent = [k](double x) { return std::tan(std::asin(k * std::sin(x))); };
            const double h = 1e-5;
            const double area = (std::pow(tangent(i + h), 2) - std::pow(tangent(i - h), 2)) / 2;
            const double light = std::cos(lightAngle(i - h, k)) - std::cos(lightAngle(i + h, k));
            EXPECT_NEAR(steradiansPerArea(i, k) * area / light, 1, 1e-6) << k << " " << i;
        }
}

const MirrorBall kBall{{0.3, -0.2, 0.25}, 0.25, 0.8};
const Vec3d kEye{0.1, -1.9, 0.8};

TEST(BallView, RaysToDirectionsAreMirroredThere) {
    const BallView view(kBall, kEye, pi / 2);
    int seen = 0;
    for (int n = 0; n < 500; ++n) {
        const double z = 1 - (2 * n + 1) / 500.0, turn = 2.4 * n;
        const Vec3d direction{std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
        const std::optional<Vec3d> ray = view.rayToDirection(direction);
        if (!ray) continue;
        ++seen;
        const std::optional<Vec3d> mirrored = reflectedDirection(kBall, kEye, *ray);
        ASSERT_TRUE(mirrored) << n;
        EXPECT_LT(distanceBetween(*mirrored, direction), 1e-8) << n;
    }
    // The hidden share is (1 - sqrt(1 - (r/d)^2)) / 2: .5% here, 2 or 3 directions of 500.
    EXPECT_GE(seen, 496);
    EXPECT_LT(seen, 500);
}

TEST(BallView, RaysToPlacesAreMirroredThroughThem) {
    const BallView view(kBall, kEye, pi / 2);
    int seen = 0, hidden = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            const Vec3d place{-2 + 0.1 * x + 0.013, -2 + 0.1 * y + 0.017, 0};
            const std::optional<Vec3d> ray = view.rayToPlace(place);
            if (!ray) {
                ++hidden;
                // It is hidden only where the ball stands between: beyond the plane of its outline.
                EXPECT_LT(dot(place - kBall.center, normalized(kEye - kBall.center)), 0) << place.x << " " << place.y;
                continue;
            }
            ++seen;
            const Vec3d center = kBall.center - kEye;
            const double along = dot(*ray, center);
            const double s = along - std::sqrt(along * along - dot(center, center) + kBall.radius * kBall.radius);
            const std::optional<Vec3d> mirrored = reflectedDirection(kBall, kEye, *ray);
            ASSERT_TRUE(mirrored);
            const Vec3d towards = normalized(place - (kEye + s * *ray));
            EXPECT_LT(distanceBetween(*mirrored, towards), 1e-7) << place.x << " " << place.y;
        }
    EXPECT_GT(hidden, 10);
    EXPECT_GT(seen, 1400);
}

TEST(BallView, KnowsWhatIsFarAwayAsADirection) {
    const BallView view(kBall, kEye, pi / 2);
    const Vec3d direction = normalized(Vec3d{0.4, -0.5, -0.1});
    EXPECT_LT(distanceBetween(*view.rayToPlace(kBall.center + 1e7 * direction), *view.rayToDirection(direction)), 1e-7);
}

TEST(BallView, StaysInsideOfTheMostIncidence) {
    const double most = 1.3;
    const BallView view(kBall, kEye, most);
    const Vec3d behind = normalized(kBall.center - kEye), away = normalized(Vec3d{0.3, 0.9, -0.35});
    EXPECT_FALSE(view.rayToDirection(behind));
    const std::optional<Vec3d> ray = view.rayToDirection(away);
    ASSERT_TRUE(ray);
    const double sine = length(cross(*ray, behind));
    EXPECT_NEAR(std::asin(sine * length(kEye - kBall.center) / kBall.radius), most, 1e-9);
    EXPECT_FALSE(view.rayToPlace(kBall.center));
}

}  // namespace
}  // namespace penumbra::test_mirror_ball
