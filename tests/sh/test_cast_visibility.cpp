#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sh/cast/cast_visibility.h"
#include "sh/cast/log_visibility.h"
#include "sh/mirrored_product.h"
#include "sh/visibility_convention.h"
#include "tests/difference.h"
#include "tests/sh/caster_scenes.h"

namespace penumbra::test_cast_visibility {
namespace {

// Around a person, inside of it and far away.
std::vector<Vec3> somePlaces(std::size_t count) {
    std::vector<Vec3> places;
    for (std::size_t k = 0; k < count; ++k) {
        const float angle = 0.7f * float(k), distance = 0.011f * float(k % 200);
        places.push_back({distance * std::cos(angle), distance * std::sin(angle), 0.017f * float(k % 101)});
    }
    return places;
}

// Measured: 1.7e-6 to 4.1e-6.
TEST(CastVisibility, IsTheExponentialOfTheNetLogOnEveryPath) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    for (const CastPath& path : pathsOf<CastPath>())
        for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
            const std::size_t n = std::size_t(coefficientCount(order));
            const std::vector<Vec3> places = somePlaces(403);  // the last block is not full
            std::vector<float> out(places.size() * n), expected(n);
            castVisibility(order, person, places, out, path);
            Largest worst;
            for (std::size_t r = 0; r < places.size(); ++r) {
                expOfLog(expTables(order), {}, netLogAt(order, person, places[r]), expected);
                for (std::size_t i = 0; i < n; ++i) worst.add(std::abs(out[r * n + i] - expected[i]));
            }
            EXPECT_LT(worst, 2e-5) << "order " << order;
        }
}

// Golden files have the plain rule, which the kernel does not know. Measured: V differs by .0001 to .0084 (RMS over the
// sphere).
TEST(CastVisibility, ComesNearGolden) {
    const auto golden = readGolden("cast_and_self.json");
    for (const CastPath& path : pathsOf<CastPath>())
        for (const auto& test : golden.at("cases")) {
            const std::vector<CasterSphere> spheres = inFloats(goldenSpheres(test.at("centres"), test.at("radii")));
            const std::vector<Vec3> at = {toFloat(vec3(test.at("position")))};
            const std::vector<double> expected = doubles(test.at("cast_order5"));
            std::vector<float> out(25);
            castVisibility(5, spheres, at, out, path);
            double sum = 0;
            for (std::size_t i = 0; i < 25; ++i) sum += (out[i] - expected[i]) * (out[i] - expected[i]);
            EXPECT_LT(std::sqrt(sum / (4 * std::numbers::pi)), 0.012);
        }
}

// The result equals the scalar functions for spheres in each point's own frame, mirrored at its horizon.
TEST(CastVisibility, IsMirroredAtEachHorizon) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    const std::vector<Vec3> places = somePlaces(205);
    std::vector<Vec3> normals, tangents;
    for (std::size_t r = 0; r < places.size(); ++r) {
        const float a = 0.3f * float(r), b = 0.7f * float(r);
        normals.push_back({std::cos(a) * std::cos(b), std::sin(b), std::sin(a) * std::cos(b)});
        tangents.push_back({-std::sin(a), 0, std::cos(a)});
    }
    for (const CastPath& path : pathsOf<CastPath>()) {
        std::vector<float> out(places.size() * kMirroredCast), log(25), v(36), expected(kMirroredCast);
        castMirrored(person, {places, normals, tangents}, {}, out, path);
        for (std::size_t r = 0; r < places.size(); ++r) {
            std::vector<CasterSphere> local;
            for (const CasterSphere& s : person) {
                const Vec3 way = s.center - places[r];
                local.push_back(
                    {{dot(way, tangents[r]), dot(way, cross(normals[r], tangents[r])), dot(way, normals[r])},
                     s.radius});
            }
            log = netLogAt(5, local, {});
            expOfLog(expTables(5), {}, log, std::span(v).first(25));
            mirrorAtHorizon(6, v, expected);
            for (std::size_t i = 0; i < kMirroredCast; ++i)
                EXPECT_NEAR(out[r * kMirroredCast + i], expected[i], 5e-5f) << r;
        }
    }
}

// Points that are their own anchors see what they see without any: what anchors sum and what they leave out is all.
TEST(CastVisibility, AnchorsShareTheSpheresWithTheirReceivers) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    const std::vector<Vec3> places = somePlaces(205), normals(205, {0, 0, 1}), tangents(205, {1, 0, 0});
    std::vector<std::uint16_t> anchor(4 * places.size());
    std::vector<float> weight(anchor.size());
    for (std::size_t r = 0; r < places.size(); ++r) {
        for (std::size_t a = 0; a < 4; ++a) anchor[4 * r + a] = std::uint16_t(r);
        weight[4 * r] = 0.75f, weight[4 * r + 1] = 0.25f;
    }
    for (const CastPath& path : pathsOf<CastPath>())
        for (const float spacing : {0.001f, 0.05f, 10.0f}) {  // all far, some near, all near
            const CastFade fade{0.0001f, 0.0003f};
            std::vector<float> values(places.size() * anchorStride(person.size())), out(places.size() * kMirroredCast),
                expected(out);
            castAnchors(person, places, spacing, fade, values, path);
            castMirrored(person, {values.data(), anchorStride(person.size()), anchor.data(), weight.data()},
                         {places, normals, tangents}, fade, out, path);
            castMirrored(person, {places, normals, tangents}, fade, expected, path);
            EXPECT_LT(largestDifference(out, expected), 1e-4f) << spacing;
        }
}

// A sphere counts whole above one share of the sphere of directions, not at all below another, and in part between.
TEST(CastVisibility, FadesWithDistance) {
    const std::vector<CasterSphere> sphere = {{{0, 0, 0}, 1}};
    const std::vector<Vec3> places = {{0, 0, -4}, {0, 0, -8}, {0, 0, -12}}, normals(3, {0, 0, 1}),
                            tangents(3, {1, 0, 0});
    std::vector<float> whole(3 * kMirroredCast), faded(whole);
    castMirrored(sphere, {places, normals, tangents}, {}, whole);
    castMirrored(sphere, {places, normals, tangents}, {1 / 400.0f, 1 / 100.0f}, faded);
    const float free = 3.5449077f;
    EXPECT_EQ(faded[0], whole[0]);
    const float part = (faded[kMirroredCast] - free) / (whole[kMirroredCast] - free);
    EXPECT_NEAR(part, (1 / 256.0 - 1 / 400.0) / (1 / 100.0 - 1 / 400.0), 0.02);
    EXPECT_EQ(faded[2 * kMirroredCast], free);
}

// A point that sinks into a sphere of 5 cm sees it fade: E is linear in the distance from the center. Measured: .0223.
TEST(CastVisibility, FadesTowardsTheCenter) {
    const std::vector<CasterSphere> sphere = {{{0, 0, 0}, 0.05f}};
    std::vector<Vec3> places;
    for (int k = 0; k <= 60; ++k) places.push_back({0, 0, -0.001f * float(k)});
    const std::vector<Vec3> normals(places.size(), {0, 0, 1}), tangents(places.size(), {1, 0, 0});
    std::vector<float> out(places.size() * kMirroredCast), weights(kMirroredCast);
    castMirrored(sphere, {places, normals, tangents}, {0.0001f, 0.0003f}, out);
    ambientWeights(parseConvention("D6"), weights);
    const auto ambientAt = [&](std::size_t r) {
        double e = 0;
        for (std::size_t i = 0; i < kMirroredCast; ++i) e += double(weights[i] * out[r * kMirroredCast + i]);
        return e;
    };
    EXPECT_NEAR(ambientAt(0), 1, 1e-5);
    for (std::size_t r = 1; r <= 50; ++r) {
        EXPECT_NEAR(ambientAt(r), 1 - double(r) / 50, 0.06) << r << " mm";
        EXPECT_LT(std::abs(ambientAt(r) - ambientAt(r - 1)), 0.03) << r << " mm";
    }
}

TEST(CastVisibility, OfNothingIsFreeSight) {
    for (const CastPath& path : pathsOf<CastPath>()) {
        const std::vector<CasterSphere> nothing = {{{0, 0, 0}, 1}, {{0, 0, 1e-7f}, 1e-8f}, {{1, 0, 0}, 0}};
        const std::vector<Vec3> places = {{0, 0, 0}, {0, 0, 1e-7f}};
        std::vector<float> out(2 * 25, 7.0f);
        for (const std::vector<CasterSphere>& spheres : {nothing, {}}) {
            castVisibility(5, spheres, places, out, path);
            for (std::size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], i % 25 ? 0 : 3.5449077f, 1e-6f);
        }
        castVisibility(5, nothing, {}, {}, path);
    }
}

}  // namespace
}  // namespace penumbra::test_cast_visibility
