// A ground with heights: what its points see, whom it shadows, who stands on it, and how it looks.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "player/render/flip.h"
#include "player/scene/cast_on.h"
#include "player/scene/scene_field.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"
#include "sh/light/analytic_light.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"
#include "tests/sh/height_samples.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_scene_field {
namespace {

namespace fs = std::filesystem;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

class SceneFieldTest : public ::testing::Test {
protected:
    fs::path folder_ = fs::path(::testing::TempDir()) / "scene_field";

    void SetUp() override {
        fs::create_directories(folder_);
        const Packed packed =
            packAsset(synthetic::composedTube(kTube), {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
        std::ofstream(folder_ / "tube.pnb", std::ios::binary)
            .write(reinterpret_cast<const char*>(packed.bytes.data()), std::streamsize(packed.bytes.size()));
    }
    // `heights` are keys of the ground's heights, `tube` more keys of the tube.
    PosedScene scene(const std::string& heights, const std::string& tube = "", const std::string& ground = "") const {
        return PosedScene(parseScene(R"({"version": 1, "characters": [{"asset": "tube.pnb")" + tube +
                                         R"(}], "ground": {)" + ground + R"("heights": {)" + heights + "}}}",
                                     "s.json", folder_));
    }
};

const char* const kLevel = R"("analytic": "waves:height=0", "rows": 65, "columns": 65, "cell": 0.05)";

std::vector<float> fieldE(const PosedScene& scene, FrameVertices& points) {
    scene.field()->evaluate(2, points);
    scene.field()->castOn(scene.cast(), 2, points);
    return fieldAmbient(scene.field()->convention(), points);
}

// A level field is the level ground: its points stand where they do, see what they do, and show what they do.
// Measured: 0.0045 of E, which is the step from the 6 bands of the one to the 5 of the other, and 0.004 of radiance.
TEST_F(SceneFieldTest, OfLevelHeightsIsTheLevelGround) {
    const PosedScene field = scene(kLevel, R"(, "position": [0, -0.05, 0])");
    const PosedScene level(parseScene(
        R"({"version": 1, "characters": [{"asset": "tube.pnb", "position": [0, -0.05, 0]}],
            "ground": {"size": 3.2, "resolution": 65}})",
        "s.json", folder_));
    FrameVertices points;
    const std::vector<float> e = fieldE(field, points);
    GroundVertices ground = groundVertices(level, 2);
    const std::vector<float> expected = groundAmbient(ground);
    std::vector<double> sh64 = projectLights(partsOf(parseLights("sky:elevation=40,azimuth=20")), 4);
    const std::vector<float> sh(sh64.begin(), sh64.end());
    const LightView light{"sky", 4, sh};
    FieldLook look(*field.file().ground, field.field()->convention(), AssetView(), light);
    std::vector<Vec3> radiance;
    look.shade(points, {3, 4, 5}, 2, radiance);
    const std::vector<Vec3> flat = groundRadiance(ground, light, Mat3d(), {0.5f, 0.5f, 0.5f}, 2);
    Largest brightest, off, off_radiance;
    double least = 1;
    for (std::size_t r = 0; r < 65; ++r)
        for (std::size_t c = 0; c < 65; ++c) {
            const std::size_t of_field = r * 65 + c, of_level = c * 65 + r;  // rows go along z, and along x
            EXPECT_NEAR(length(points.positions[of_field] - ground.positions[of_level]), 0, 1e-5);
            off.add(std::abs(e[of_field] - expected[of_level]));
            least = std::min(least, double(e[of_field]));
            off_radiance.add(length(radiance[of_field] - flat[of_level]));
            brightest.add(length(flat[of_level]));
        }
    EXPECT_LT(least, 0.6);
    EXPECT_LT(off, 0.02);
    EXPECT_LT(off_radiance, 0.03 * brightest);
    EXPECT_GT(brightest, 0.05);
}

TEST_F(SceneFieldTest, TrianglesFaceUp) {
    const PosedScene waves = scene(R"("analytic": "waves", "rows": 9, "columns": 7)");
    FrameVertices points;
    fieldE(waves, points);
    const std::vector<std::uint32_t> triangles = fieldTriangles(waves.field()->heights().field().grid());
    EXPECT_EQ(triangles.size(), 6u * 8 * 6);
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
        const Vec3 a = points.positions[triangles[t]], b = points.positions[triangles[t + 1]],
                   c = points.positions[triangles[t + 2]];
        EXPECT_GT(cross(b - a, c - a).y, 0);
    }
    for (std::size_t v = 0; v < points.positions.size(); ++v) {
        EXPECT_NEAR(dot(points.normals[v], points.tangents[v]), 0, 1e-5);
        EXPECT_GT(points.normals[v].y, 0);
    }
}

// Walls at the border reach from its points to the least height, so that nothing shines under a dune that it cuts.
TEST_F(SceneFieldTest, CastsAsASolidInTheMapsOfSuns) {
    for (const char* const heights :
         {R"("analytic": "waves", "rows": 9, "columns": 7)", R"("analytic": "waves", "rows": 1, "columns": 7)",
          R"("analytic": "waves", "rows": 1, "columns": 1)"}) {
        const PosedScene waves = scene(heights);
        const HeightGrid& grid = waves.field()->heights().field().grid();
        std::vector<Vec3> points;
        waves.field()->heights().castingPoints(points);
        const std::vector<std::uint32_t> triangles = castingTriangles(grid);
        float least = points[0].y;
        for (const Vec3 p : points) least = std::min(least, p.y);
        const std::size_t field = fieldTriangles(grid).size();
        double wall = 0, border = 0;  // square metres
        for (std::size_t t = 0; t < triangles.size(); t += 3) {
            ASSERT_LT(std::max({triangles[t], triangles[t + 1], triangles[t + 2]}), points.size());
            const Vec3 a = points[triangles[t]], b = points[triangles[t + 1]], c = points[triangles[t + 2]];
            if (t >= field) wall += 0.5 * double(length(cross(b - a, c - a)));
        }
        const auto height = [&](int r, int c) { return double(waves.field()->heights().point(r, c).y - least); };
        for (int c = 0; c + 1 < grid.columns; ++c)
            for (const int r : {0, grid.rows - 1}) border += 0.5 * (height(r, c) + height(r, c + 1));
        for (int r = 0; r + 1 < grid.rows; ++r)
            for (const int c : {0, grid.columns - 1}) border += 0.5 * (height(r, c) + height(r + 1, c));
        EXPECT_NEAR(wall, border, 1e-4 * std::max(border, 1.0)) << heights;
    }
}

// What looks down sees nothing but the ground, what looks up sees the sky, and what stands far from hills but for those
// on one side is darker on that side.
TEST_F(SceneFieldTest, ShadowsCharactersByItsHorizonAtTheirVertices) {
    std::ofstream(folder_ / "wall.hdr") << "NROWS 65\nNCOLS 65\n";
    std::ofstream wall(folder_ / "wall.raw", std::ios::binary);
    for (int r = 0; r < 65; ++r)
        for (int c = 0; c < 65; ++c) {
            const std::int16_t height = c > 44 ? 300 : 0;  // x > 0.6 m: 3 m high
            wall.write(reinterpret_cast<const char*>(&height), 2);
        }
    wall.close();
    const PosedScene walled = scene(R"("file": "wall.raw", "cell": 0.05, "scale": 0.01)");
    const std::vector<Vec3> at(4, Vec3{0, 1, 0}), normals = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, 0, 0}},
                                                  tangents = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    std::vector<float> mirrored(4 * kFarCoefficients), e(4), weights(kFarCoefficients);
    walled.field()->visibleFrom({at, normals, tangents}, mirrored);
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    for (std::size_t v = 0; v < 4; ++v)
        for (std::size_t i = 0; i < kFarCoefficients; ++i) e[v] += weights[i] * mirrored[v * kFarCoefficients + i];
    EXPECT_LT(e[1], 0.03);         // down
    EXPECT_NEAR(e[3], 0.5, 0.05);  // away from the wall: the upper half
    EXPECT_LT(e[2], 0.12);         // towards it
    EXPECT_LT(e[0], 0.9);          // up: the wall hides a part
    EXPECT_GT(e[0], 0.55);
    // The same through the numbers of the tube.
    FrameVertices own;
    ownVertices(*walled.members()[0], 1, own);
    const FrameVertices shadowed = memberVertices(walled, 0, 1);
    const ModelView& model = walled.members()[0]->asset->view.model;
    std::vector<float> before(own.positions.size()), after(before.size());
    ambient(model.convention, model.stride, own.coefficients, before);
    ambient(model.convention, model.stride, shadowed.coefficients, after);
    for (std::size_t v = 0; v < before.size(); ++v) EXPECT_LT(after[v], before[v] + 0.03f) << v;
    // Light that bounces fades by the share of a white sky that is left.
    std::vector<float> coefficients(4 * std::size_t(model.stride)), bounced(4 * kIndirectStride, 2.0f);
    walled.field()->shadow({at, normals, tangents}, model, 1, coefficients, bounced);
    for (std::size_t i = 0; i < bounced.size(); ++i)
        EXPECT_NEAR(bounced[i], 2 * std::clamp(e[i / kIndirectStride], 0.0f, 1.0f), 1e-5f) << i;
}

TEST_F(SceneFieldTest, ItsHeightIsThatOfTheTrianglesThatAreDrawn) {
    const PosedScene dunes =
        scene(R"("analytic": "dunes:height=0.9,length=3", "rows": 13, "columns": 17, "cells": [0.7, 0.4])", "",
              R"("height": 2, "centre": [5, 0, -3], )");
    const GroundHeights& heights = dunes.field()->heights();
    const std::vector<std::uint32_t> corners = fieldTriangles(heights.field().grid());
    const auto at = [&](std::size_t i) { return toDouble(heights.point(int(corners[i] / 17), int(corners[i] % 17))); };
    for (std::size_t t = 0; t < corners.size(); t += 3)
        for (const Vec3d share : {Vec3d{0.34, 0.33, 0.33}, {0.9, 0.06, 0.04}, {0.02, 0.49, 0.49}}) {
            const Vec3d p = at(t) * share.x + at(t + 1) * share.y + at(t + 2) * share.z;
            EXPECT_NEAR(heights.heightAt(p.x, p.z), p.y, 2e-6) << t;
        }
}

TEST_F(SceneFieldTest, WhoStandsOnItGoesUpAndDownWithIt) {
    PosedScene rocking = scene(R"("analytic": "waves:height=0.5,length=3", "rows": 64, "columns": 64, "cell": 0.1)",
                               R"(, "position": [0.4, 0.01, -0.7], "on_ground": true)", R"("height": 2, )");
    std::vector<float> seen;
    FrameVertices vertices;
    for (const double seconds : {0.0, 0.3, 0.6}) {
        rocking.pose(seconds);
        const SceneMember& member = *rocking.members()[0];
        const float y = member.to_scene.m[7];
        // Below the pose of this moment.
        skinFrame(member.evaluator, 1, vertices);
        const double under = rocking.field()->heights().heightUnder(vertices.positions, member.to_scene);
        EXPECT_FLOAT_EQ(y, float(under) + 0.01f);
        EXPECT_GT(std::abs(under - rocking.field()->heights().heightAt(0.4, -0.7)), 1e-4);
        EXPECT_NEAR(y, 2, 1.5);
        seen.push_back(y);
    }
    EXPECT_NE(seen[0], seen[1]);
    EXPECT_NE(seen[1], seen[2]);
    rocking.pose({});
    EXPECT_EQ(rocking.members()[0]->to_scene.m[7], seen[0]);
}

TEST_F(SceneFieldTest, AfterAnEditIsThatOfTheWhole) {
    const char* const dunes = R"("analytic": "dunes:height=0.6,length=3", "rows": 96, "columns": 80, "cell": 0.1)";
    const PosedScene edited = scene(dunes), whole = scene(dunes);
    FrameVertices points, expected;
    edited.field()->evaluate(2, points);
    const std::vector<float> hill(9 * 7, 1.2f);
    edited.field()->set({20, 30, 29, 37}, hill);
    whole.field()->set({20, 30, 29, 37}, hill);
    edited.field()->evaluate(1, points);
    whole.field()->lookAgain();
    whole.field()->evaluate(2, expected);
    EXPECT_EQ(points.coefficients, expected.coefficients);
    EXPECT_EQ(points.normals, expected.normals);
}

// A brush of 5 points on 256 x 256, beside a character. Only receivers with a sample of something that changed look
// again, and only points near those that see something else are computed and cast on again. What comes out is that of
// the whole, but for the order in which casts are summed (2.4e-6 measured). Measured: 67% of the receivers, 14% of the
// points, with and without finer receivers.
TEST_F(SceneFieldTest, AfterAStrokeOnlyWhatSeesItIsComputed) {
    const std::string dunes =
        R"("analytic": "dunes:height=1,length=4", "rows": 256, "columns": 256, "cell": 0.1, "step": 4)";
    for (const bool refine : {false, true}) {
        const std::string heights = dunes + (refine ? "" : R"(, "refine": false)");
        const PosedScene edited = scene(heights), whole = scene(heights);
        FrameVertices points, expected;
        EXPECT_EQ(edited.field()->update(edited.cast(), FieldPoints::kNew, 2, points), 256u * 256u);
        EXPECT_EQ(edited.field()->update(edited.cast(), FieldPoints::kKept, 2, points), 0u);
        const Vec3 at = edited.field()->heights().point(60, 70);
        for (const float rise : {0.4f, -0.6f}) {
            edited.field()->brush(at, 0.5f, rise);
            whole.field()->brush(at, 0.5f, rise);
            const std::size_t receivers = edited.field()->awake();
            const std::size_t updated = edited.field()->update(edited.cast(), FieldPoints::kKept, 2, points);
            whole.field()->lookAgain();
            whole.field()->update(whole.cast(), FieldPoints::kNew, 1, expected);
            std::printf("a stroke over 9 x 9 points wakes %zu of %zu receivers and %zu of 65536 points\n", receivers,
                        edited.field()->receiverCount(), updated);
            EXPECT_LT(double(receivers), 0.7 * double(edited.field()->receiverCount()));
            EXPECT_GT(receivers, 4u);
            EXPECT_LT(updated, 65536u / 7);
            EXPECT_GT(updated, 81u);
            EXPECT_LT(largestDifference(points.coefficients, expected.coefficients), 1e-5);
            EXPECT_EQ(points.normals, expected.normals);
            EXPECT_EQ(points.positions, expected.positions);
        }
        EXPECT_EQ(edited.field()->update(edited.cast(), FieldPoints::kKept, 2, points), 0u);
        // Beside the field, without an extent, and of no number.
        const float nan = std::numeric_limits<float>::quiet_NaN();
        edited.field()->brush({1e6f, 0, 0}, 0.5f, 1);
        edited.field()->brush(at, 0, 1);
        edited.field()->brush({nan, nan, nan}, 0.5f, 1);
        edited.field()->brush(at, 0.5f, nan);
        EXPECT_EQ(edited.field()->update(edited.cast(), FieldPoints::kKept, 2, points), 0u);
    }
}

// What a character hides from a field is interpolated in smooth blocks. Measured against each point for itself: 0.0008
// of E at most on waves. On a rough field, where normals turn from point to point, no block is smooth. The bound is
// that of the level ground.
TEST_F(SceneFieldTest, CastsByBlocksAreThoseOfEachPoint) {
    std::ofstream(folder_ / "rough.hdr") << "NROWS 120\nNCOLS 123\n";
    std::ofstream rough(folder_ / "rough.raw", std::ios::binary);
    for (const float z : fractalHeights(120, 123, 1.6, 0.08)) {
        const auto height = std::int16_t(std::lround(10000 * z));
        rough.write(reinterpret_cast<const char*>(&height), 2);
    }
    rough.close();
    for (const char* heights : {R"("analytic": "waves:height=0.1,length=3", "rows": 120, "columns": 123, "cell": 0.05)",
                                R"("file": "rough.raw", "cell": 0.05, "scale": 0.0001)",
                                R"("analytic": "waves:height=0.1", "rows": 1, "columns": 97, "cell": 0.03)",
                                R"("analytic": "waves:height=0.1", "rows": 65, "columns": 2, "cell": 0.03)"}) {
        const PosedScene one = scene(heights, R"(, "position": [0.1, 0, 0], "on_ground": true)");
        FrameVertices points;
        one.field()->evaluate(2, points);
        std::vector<float> each = points.coefficients, mirrored;
        const CastReceivers all{points.positions, points.normals, points.tangents};
        castOn(one.cast(), {}, all, 2, mirrored);
        CastProduct(one.field()->convention())(each, kFieldStride, mirrored);
        one.field()->castOn(one.cast(), 2, points);
        const std::vector<float> e = fieldAmbient(one.field()->convention(), points);
        FrameVertices expected = points;
        expected.coefficients = each;
        const std::vector<float> e_each = fieldAmbient(one.field()->convention(), expected);
        Largest most, hidden;
        one.field()->evaluate(2, points);
        const std::vector<float> open = fieldAmbient(one.field()->convention(), points);
        for (std::size_t v = 0; v < e.size(); ++v) {
            most.add(std::abs(e[v] - e_each[v]));
            hidden.add(open[v] - e[v]);
        }
        std::printf("%.30s: casts by blocks are off by %.4f of E, of %.2f that is hidden\n", heights, most.value(),
                    hidden.value());
        EXPECT_LT(most, 0.005) << heights;
        EXPECT_GT(hidden, 0.05) << heights;
    }
}

// A caster that is smaller than a block is not missed: on a coarse field each point looks for itself.
TEST_F(SceneFieldTest, CastsOnCoarseFieldsMissNobody) {
    const PosedScene coarse = scene(R"("analytic": "waves:height=0", "rows": 12, "columns": 12, "cell": 0.7)",
                                    R"(, "position": [0.7, -0.1, 0.35])");
    FrameVertices points;
    std::vector<float> mirrored;
    const std::vector<float> e = fieldE(coarse, points);
    coarse.field()->evaluate(1, points);
    castOn(coarse.cast(), {}, {points.positions, points.normals, points.tangents}, 1, mirrored);
    CastProduct(coarse.field()->convention())(points.coefficients, kFieldStride, mirrored);
    EXPECT_EQ(e, fieldAmbient(coarse.field()->convention(), points));
    EXPECT_LT(*std::ranges::min_element(e), 0.9f);
}

// FLIP of a map from above against full resolution, on steep and fine ground. Measured: at most 0.0006, and 0.046 to
// 0.089 without more receivers.
TEST_F(SceneFieldTest, SubSamplingOfSteepGroundIsNearFullResolution) {
    constexpr int kSide = 192;
    std::ofstream(folder_ / "steep.hdr") << "NROWS 192\nNCOLS 192\n";
    std::ofstream steep(folder_ / "steep.raw", std::ios::binary);
    for (const float z : fractalHeights(kSide, kSide, 1.8, 1.1)) {
        const auto height = std::int16_t(std::lround(1000 * z));
        steep.write(reinterpret_cast<const char*>(&height), 2);
    }
    steep.close();
    for (const int sun : {8, 25, 60}) {
        const std::vector<double> sh64 =
            projectLights(partsOf(parseLights("sky:turbidity=3,elevation=" + std::to_string(sun))), 5);
        const std::vector<float> sh(sh64.begin(), sh64.end());
        const auto mapOf = [&](const char* keys) {
            const PosedScene ground =
                scene(R"("file": "steep.raw", "cell": 0.1, "scale": 0.001, )" + std::string(keys));
            FrameVertices points;
            std::vector<Vec3> radiance;
            ground.field()->evaluate(2, points);
            FieldLook(*ground.file().ground, ground.field()->convention(), AssetView(), {"sky", 5, sh})
                .shade(points, {0, 9, 9}, 2, radiance);
            return radiance;
        };
        std::vector<Vec3> full = mapOf(R"("step": 1)"), refined = mapOf(R"("step": 4)"),
                          coarse = mapOf(R"("step": 4, "refine": false)");
        Largest most;
        for (const Vec3 p : full) most.add(p.y);
        const auto exposed = [&](std::vector<Vec3> pixels) {
            for (Vec3& p : pixels)
                for (int c = 0; c < 3; ++c) p[c] = std::min(p[c] * 0.8f / float(most), 1.0f);
            return pixels;
        };
        const auto flip = [&](const std::vector<Vec3>& picture) {
            double sum = 0;
            for (const float e : flipMap(kSide, kSide, exposed(full), exposed(picture), 0))
                sum += double(e) / (kSide * kSide);
            return sum;
        };
        std::printf("sun %d degrees high: FLIP %.4f, without more receivers %.4f\n", sun, flip(refined), flip(coarse));
        EXPECT_LT(flip(refined), 0.02);
        EXPECT_GT(flip(coarse), 0.02);  // that is what the ground asks for
    }
}

// Strokes at corners and edges, and those larger than the field, of every border.
TEST_F(SceneFieldTest, StrokesAtTheBorderAreThoseOfTheWhole) {
    for (const std::string border : {"clamped", "periodic", "open"})
        for (const std::string step : {"1", "4", "8"}) {
            const std::string heights = R"("analytic": "waves:height=0.4,length=2", "rows": 42, "columns": 37,
                "cells": [0.1, 0.13], "border": ")" +
                                        border + R"(", "step": )" + step;
            const PosedScene edited = scene(heights), whole = scene(heights);
            FrameVertices points, expected;
            edited.field()->update(edited.cast(), FieldPoints::kNew, 1, points);
            for (const auto& [row, column, radius] : {std::tuple{0, 0, 0.3f},
                                                      {41, 36, 0.3f},
                                                      {41, 3, 0.05f},
                                                      {20, 0, 0.15f},
                                                      {17, 22, 0.02f},
                                                      {5, 5, 30.0f}}) {
                const Vec3 at = edited.field()->heights().point(row, column);
                edited.field()->brush(at, radius, 0.3f);
                whole.field()->brush(at, radius, 0.3f);
                edited.field()->update(edited.cast(), FieldPoints::kKept, 1, points);
                whole.field()->lookAgain();
                whole.field()->update(whole.cast(), FieldPoints::kNew, 1, expected);
                EXPECT_LT(largestDifference(points.coefficients, expected.coefficients), 1e-5)
                    << border << " " << step << " " << row;
                EXPECT_EQ(points.normals, expected.normals) << border << " " << step << " " << row;
            }
        }
}

TEST_F(SceneFieldTest, OfATimeIsThatOfTheTimeHoweverOneGotThere) {
    const char* const waves = R"("analytic": "waves", "rows": 40, "columns": 52, "cell": 0.1, "border": "periodic")";
    PosedScene walked = scene(waves), there = scene(waves);
    FrameVertices points, expected;
    for (const double seconds : {0.0, 0.5, 1.25}) {
        walked.pose(seconds);
        walked.field()->evaluate(2, points);
    }
    there.pose(1.25);
    there.field()->evaluate(1, expected);
    EXPECT_EQ(largestDifference(points.coefficients, expected.coefficients), 0);
}

TEST(HeightFrames, AllocateNothing) {
    const HeightGrid grid{40, 200, 0.1f, 0.1f};
    const std::vector<AnalyticHeights> waves = parseAnalyticHeights("waves");
    std::vector<float> heights(grid.size()), coefficients(128 * kFieldStride);
    std::vector<Vec3> normals(128), tangents(128);
    analyticHeights(waves, grid, 0, 0, 40, heights);
    HeightField field(grid, heights);
    HeightVisibility visibility(field, 5, 4);
    const auto frame = [&](double seconds) {
        analyticHeights(waves, grid, seconds, 0, 40, heights);
        visibility.wake(field, field.set(heights));
        visibility.evaluate(field, 0, visibility.receiverRows());
        for (int row = 0; row < 40; ++row)
            for (const int first : {0, 72})
                visibility.coefficients(field, row, first, normals, tangents, kFieldStride, coefficients);
    };
    frame(0);
    const std::size_t before = allocationCount();
    frame(1);
    frame(2);
    EXPECT_EQ(allocationCount(), before);
}

TEST_F(SceneFieldTest, RefusesOtherWaysToCastAndMaterialsThatAreNotThere) {
    try {
        const PosedScene folded(parseScene(R"({"version": 1, "characters": [{"asset": "tube.pnb"}],
            "ground": {"heights": {"analytic": "waves"}}})",
                                           "s.json", folder_),
                                {CastMode::kFolded, {}});
        ADD_FAILURE() << "heights are not folded";
    } catch (const UsageError& error) {
        EXPECT_EQ(error.what(),
                  std::string("cast: s.json: /ground/heights: a ground with heights joins as a product alone"));
    }
    const PosedScene sandy = scene(kLevel, "", R"("material": "sand", )");
    std::vector<float> sh(3, 1.0f);
    EXPECT_THROW(FieldLook(*sandy.file().ground, sandy.field()->convention(), AssetView(), {"white", 1, sh}),
                 InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_scene_field
