#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sh/far/part_field.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"
#include "tests/difference.h"

namespace penumbra::test_part_field {
namespace {

constexpr float kRadius = 0.5f;
constexpr Vec3 kCenter{0.25f, -0.5f, 1};
constexpr float kFade = 0.05f;
using Coefficients = std::array<float, kFieldCoefficients>;

// V - 1 of a solid sphere, seen from outside: a cap around the way to its center is blocked.
Coefficients blockedBySphere(Vec3 point) {
    const Vec3d way = toDouble(kCenter) - toDouble(point);
    std::array<double, kFieldOrder> zonal;
    std::array<double, kFieldCoefficients> lobe;
    capVisibilityZonal(std::asin(std::min(double(kRadius) / length(way), 1.0)), zonal);
    rotateZonal(zonal, normalized(way), lobe);
    lobe[0] -= std::sqrt(4 * std::numbers::pi);
    Coefficients out;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = float(lobe[i]);
    return out;
}

// The field of the sphere, as a bake would make it: points inside hold what their nearest surface point sees.
struct SphereField {
    PartField part;
    std::vector<std::int8_t> values, distances;

    FieldTable table() const { return makeFieldTable(part, {values, distances}, kFade); }
};

SphereField sphereField() {
    SphereField out;
    PartField& part = out.part;
    part.center = kCenter;
    part.radius = kRadius;
    for (std::size_t b = 0; b < 2; ++b) {
        const float side = kRadius * (b ? 2.5f : 1.25f);
        part.boxes[b] = {kCenter - Vec3{side, side, side}, kCenter + Vec3{side, side, side}, {12, 12, 12}};
    }
    const std::vector<Vec3> points = fieldPoints(part);
    const std::size_t fine = part.boxes[0].pointCount(), coarse = part.boxes[1].pointCount();
    const auto levelOf = [&](std::size_t p) { return p < fine ? 0u : p < fine + coarse ? 1u : 2u; };
    std::vector<Coefficients> stored;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const Vec3 offset = points[p] - kCenter;
        Coefficients coefficients =
            blockedBySphere(length(offset) < kRadius ? kCenter + normalized(offset) * kRadius : points[p]);
        for (float& x : coefficients) x *= dot(offset, offset) + 0.25f * kRadius * kRadius;
        stored.push_back(coefficients);
        for (std::size_t i = 0; i < kFieldCoefficients; ++i) {
            float& scale = part.scale[levelOf(p)][std::size_t(bandOfIndex(int(i)))];
            scale = std::max(scale, std::abs(coefficients[i]) / 127);
        }
    }
    part.distance_scale = kRadius / 127;
    for (std::size_t p = 0; p < points.size(); ++p)
        for (std::size_t i = 0; i < kFieldCoefficients; ++i) {
            const float scale = part.scale[levelOf(p)][std::size_t(bandOfIndex(int(i)))];
            out.values.push_back(std::int8_t(std::lround(stored[p][i] / scale)));
        }
    for (std::size_t p = 0; p < fine; ++p) {
        const float distance = (length(points[p] - kCenter) - kRadius) / part.distance_scale;
        out.distances.push_back(std::int8_t(std::lround(std::clamp(distance, -127.0f, 127.0f))));
    }
    return out;
}

Vec3 spiralDirection(int i, int count) {
    const float z = 1 - (2 * float(i) + 1) / float(count), across = std::sqrt(1 - z * z), turn = 2.39996f * float(i);
    return {across * std::cos(turn), across * std::sin(turn), z};
}

TEST(PartField, SphereDirectionsCoverTheSphere) {
    Vec3 sum;
    for (std::size_t a = 0; a < kFieldSphereSide; ++a)
        for (std::size_t b = 0; b < kFieldSphereSide; ++b) {
            const Vec3 d = sphereDirection(a, b);
            EXPECT_NEAR(length(d), 1, 1e-6f);
            // The middle of the map is +z, and its corners are all -z.
            const bool corner = a % (kFieldSphereSide - 1) == 0 && b % (kFieldSphereSide - 1) == 0;
            if (corner) {
                EXPECT_NEAR(d.z, -1, 1e-6f);
            }
            sum += d;
        }
    EXPECT_NEAR(sphereDirection(kFieldSphereSide / 2, kFieldSphereSide / 2).z, 1, 1e-6f);
    EXPECT_NEAR(sum.x, 0, 1e-5f);
    EXPECT_NEAR(sum.y, 0, 1e-5f);
    // No direction is farther than 0.25 (14 degrees) from the nearest one.
    for (int i = 0; i < 2000; ++i) {
        float nearest = 2;
        for (std::size_t p = 0; p < kFieldSphereSide * kFieldSphereSide; ++p)
            nearest = std::min(nearest, length(spiralDirection(i, 2000) -
                                               sphereDirection(p / kFieldSphereSide, p % kFieldSphereSide)));
        ASSERT_LT(nearest, 0.25f);
    }
}

TEST(PartField, PointsStandAtTheCornersOfTheBoxesAndOnTheSpheres) {
    const PartField part = sphereField().part;
    const std::vector<Vec3> points = fieldPoints(part);
    ASSERT_EQ(points.size(), part.pointCount());
    EXPECT_EQ(points.front(), part.boxes[0].low);
    EXPECT_LT(length(points[part.boxes[0].pointCount() - 1] - part.boxes[0].high), 1e-6f);
    EXPECT_EQ(points[part.boxes[0].pointCount()], part.boxes[1].low);
    EXPECT_EQ(points[1].y, points[0].y);  // x runs fastest
    EXPECT_GT(points[1].x, points[0].x);
    EXPECT_NEAR(length(points.back() - part.center), kRadius / kFieldSphereScales.back(), 1e-6f);
}

// At a point of the grid only rounding to bytes is left. Far away V - 1 is about 5.3 r^2 / d^2 long, and .156 r^2 /
// d^2 is the largest error that was measured.
TEST(PartField, PointsOfTheGridHaveTheClosedFormOfACap) {
    const SphereField sphere = sphereField();
    const FieldTable table = sphere.table();
    const std::vector<Vec3> points = fieldPoints(sphere.part);
    Largest worst;
    for (std::size_t p = sphere.part.boxes[0].pointCount() + sphere.part.boxes[1].pointCount(); p < points.size();
         ++p) {
        if (length(points[p] - kCenter) < 3 * kRadius) continue;  // where boxes blend in
        Coefficients out;
        sampleField(table, points[p], out);
        const float factor = dot(points[p] - kCenter, points[p] - kCenter) / (kRadius * kRadius);
        worst.add(factor * distanceBetween(out, blockedBySphere(points[p])));
    }
    EXPECT_LT(worst, 0.17f);
}

// The rms error over all directions, relative to V - 1. The boxes left .122, .063 and .059 of it. The points of a
// sphere are up to 45 degrees apart, within which functions of order 6 change their sign: .355, .533 and .548 were
// left.
TEST(PartField, BetweenPointsTheClosedFormIsNear) {
    const FieldTable table = sphereField().table();
    struct Row {
        float distance, bound;
    };
    for (const Row row :
         {Row{1.1f, 0.15f}, Row{1.5f, 0.08f}, Row{2, 0.08f}, Row{3, 0.4f}, Row{6, 0.6f}, Row{20, 0.6f}}) {
        double error = 0, truth = 0;
        for (int i = 0; i < 500; ++i) {
            const Vec3 point = kCenter + spiralDirection(i, 500) * (row.distance * kRadius);
            Coefficients out;
            sampleField(table, point, out);
            const Coefficients expected = blockedBySphere(point);
            error += std::pow(double(distanceBetween(out, expected)), 2);
            truth += std::pow(double(distanceBetween(expected, Coefficients{})), 2);
        }
        EXPECT_LT(std::sqrt(error / truth), row.bound) << row.distance;
    }
}

// The largest step along a line shrinks with the steps' length, so nothing jumps at the borders of cells and levels.
TEST(PartField, ALineThroughAllLevelsHasNoJump) {
    const FieldTable table = sphereField().table();
    const auto largestStep = [&](int steps) {
        Coefficients before{}, here{};
        Largest largest;
        for (int i = 0; i <= steps; ++i) {
            const Vec3 point = kCenter + Vec3{0.07f, 0.11f, 1} * (kRadius * 30 * (2 * float(i) / float(steps) - 1));
            sampleField(table, point, here);
            if (i > 0) largest.add(distanceBetween(here, before));
            before = here;
        }
        return largest;
    };
    const float coarse = largestStep(20000), fine = largestStep(160000);
    EXPECT_LT(fine, 0.2f * coarse);  // an eighth, and .13 was measured; a jump would make it 1
}

TEST(PartField, APointInsideGoesDarkWithItsDepth) {
    const FieldTable table = sphereField().table();
    for (int i = 0; i < 200; ++i) {
        const Vec3 direction = spiralDirection(i, 200);
        Coefficients out;
        EXPECT_EQ(sampleField(table, kCenter + direction * (0.7f * kRadius), out), 1);
        EXPECT_LT(out[0], -0.5f);  // it still has what the surface there sees
        EXPECT_EQ(sampleField(table, kCenter + direction * (1.15f * kRadius), out), 0);
        EXPECT_EQ(sampleField(table, kCenter + direction * (9 * kRadius), out), 0);
    }
}

TEST(PartField, AnyFinitePointHasAFiniteValue) {
    const FieldTable table = sphereField().table();
    for (const Vec3 point : {kCenter, Vec3{1e18f, 0, 0}, Vec3{-3e38f, 3e38f, 3e38f}, kCenter + Vec3{0, 0, 1e-30f}}) {
        Coefficients out;
        sampleField(table, point, out);
        const double largest = largestMagnitude(out);
        if (length(point - kCenter) < kRadius)
            EXPECT_GT(largest, 0.5) << "inside of the sphere";
        else
            EXPECT_LT(largest, 1e-6) << point.x;
    }
}

}  // namespace
}  // namespace penumbra::test_part_field
