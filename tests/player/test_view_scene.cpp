// Tests what the window shows beside the characters, and what it keeps.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "player/frame/truth_frames.h"
#include "player/gl/screenshot.h"
#include "player/view/playback/clip_figures.h"
#include "player/view/view_settings.h"
#include "player/view/view_shapes.h"
#include "sh/light/light_rotation.h"
#include "tests/difference.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_view_scene {
namespace {

using player_test::SyntheticAsset;

TEST(ViewShapes, SphereIsClosedAndUnit) {
    const Shape sphere = unitSphere(16);
    double area = 0;
    for (const Vec3& p : sphere.positions) EXPECT_NEAR(length(p), 1, 1e-6);
    for (std::size_t i = 0; i < sphere.triangles.size(); i += 3) {
        const Vec3 a = sphere.positions[sphere.triangles[i]], b = sphere.positions[sphere.triangles[i + 1]],
                   c = sphere.positions[sphere.triangles[i + 2]];
        area += 0.5 * double(length(cross(b - a, c - a)));
    }
    EXPECT_NEAR(area, 4 * std::numbers::pi, 0.15);  // inscribed: 12.46 of 12.57
}

// Two vertices of one place have the shades of two tiles, and every square has its two triangles.
TEST(ViewShapes, GroundTilesHaveEdges) {
    for (const std::uint32_t side : {2u, 25u, 49u, 128u}) {
        const GroundTiles tiles = groundTiles(side);
        EXPECT_EQ(tiles.triangles.size(), 6 * (side - 1) * (side - 1));
        std::vector<int> shades(side * side);
        for (std::size_t v = 0; v < tiles.vertices.size(); ++v)
            shades[tiles.vertices[v]] |= tiles.shades[v] == 1 ? 1 : 2;
        EXPECT_EQ(std::ranges::count(shades, 0), 0);
        if (side == 49) {
            EXPECT_EQ(shades[2 * 49 + 1], 3) << "an edge between two tiles of 2 x 2 squares";
        }
        for (std::size_t t = 0; t < tiles.triangles.size(); t += 3)
            EXPECT_EQ(tiles.shades[tiles.triangles[t]], tiles.shades[tiles.triangles[t + 1]]);
    }
}

TEST(ClipFigures, HasTheEvaluatorsMeasureOfEveryFrame) {
    const SyntheticAsset synthetic;
    Evaluator evaluator(synthetic.asset), other(synthetic.asset);
    std::vector<float> ranges;
    const ClipView& clip = synthetic.asset.animation.clips[0];
    for (std::size_t i = 0; i < 100 && ranges.size() < clip.frame_count; ++i) computeRanges(other, clip, 1, ranges);
    ASSERT_EQ(ranges.size(), clip.frame_count);
    for (std::size_t i = 0; i < clip.frame_count; ++i) {
        const std::size_t frame = clip.first_frame + i;
        evaluator.setPose(synthetic.asset.animation.bonesOf(frame), synthetic.asset.animation.poseOf(frame));
        EXPECT_EQ(ranges[i], float(evaluator.outOfRange()));
    }
}

// The synthetic asset's truth is open everywhere. One clip is not in the truth.
TEST(ErrorStrip, IsTheErrorOfEveryFrame) {
    const SyntheticAsset synthetic;
    const AssetView& asset = synthetic.asset;
    const Evaluator evaluator(asset);
    ErrorStrip strip;
    std::vector<FrameError> errors;
    for (int i = 0; i < 10000 && errors.size() < 3; ++i) strip.compute(evaluator, synthetic.truth, 0, 0.01, errors);
    ASSERT_EQ(errors.size(), 3u);
    for (std::size_t frame = 0; frame < 3; ++frame) {
        Shot shot;
        shot.asset = &asset;
        shot.truth = &synthetic.truth;
        shot.frame = shot.truth_frame = frame;
        Evaluator other(asset);
        FrameVertices vertices;
        evaluateFrame(shot, VisibilitySource::kModel, other, 1, vertices);
        const std::vector<float> e = ambientOf(shot, vertices.coefficients, 1),
                                 truth = ambientOf(shot, truthCoefficients(shot, vertices, 1), 1);
        double sum = 0;
        Largest most;
        for (std::size_t v = 0; v < e.size(); ++v) {
            sum += double(std::abs(e[v] - truth[v]));
            most.add(std::abs(e[v] - truth[v]));
        }
        EXPECT_GT(most, 0);
        EXPECT_NEAR(double(errors[frame].mean), sum / double(e.size()), 1e-6);
        EXPECT_FLOAT_EQ(errors[frame].most, most);
        EXPECT_TRUE(errors[frame].has_truth);
    }
    AssetView partial = synthetic.truth;
    partial.animation.clips.pop_back();
    strip.compute(evaluator, partial, 1, 1000, errors);
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_FALSE(errors[0].has_truth);
    EXPECT_EQ(errors[0].mean, 0);
}

TEST(TruthFrames, SameClipNumberAndTime) {
    const SyntheticAsset synthetic;
    for (std::size_t frame = 0; frame < synthetic.asset.animation.frameCount(); ++frame)
        EXPECT_EQ(findTruthFrame(synthetic.asset, synthetic.truth, frame), frame);
    AssetView partial = synthetic.truth;
    partial.animation.clips.erase(partial.animation.clips.begin());
    EXPECT_FALSE(findTruthFrame(synthetic.asset, partial, 0));
    EXPECT_TRUE(findTruthFrame(synthetic.asset, partial, synthetic.asset.animation.clips[1].first_frame));
    AssetView late = synthetic.truth;
    std::vector<double> times(late.animation.times.begin(), late.animation.times.end());
    times[1] += 0.01;
    late.animation.times = times;
    EXPECT_TRUE(findTruthFrame(synthetic.asset, late, 0));
    EXPECT_FALSE(findTruthFrame(synthetic.asset, late, 1)) << "sampled at another time";
    const std::vector<ClipView>& clips = synthetic.asset.animation.clips;
    EXPECT_FALSE(hasTruthOf(synthetic.asset, partial, clips[0]));
    EXPECT_TRUE(hasTruthOf(synthetic.asset, partial, clips[1]));
    times[0] += 0.01;
    late.animation.times = times;
    EXPECT_TRUE(hasTruthOf(synthetic.asset, late, clips[0])) << "of its third frame only";
}

TEST(ViewSettings, AreReadAsTheyWereWritten) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "view_settings";
    std::filesystem::remove_all(folder);
    const std::filesystem::path path = folder / "deep" / "view.json";
    std::string problem;
    EXPECT_EQ(readSettings(path, problem).window.width, WindowPlace().width);
    EXPECT_TRUE(problem.empty());
    ViewSettings settings;
    settings.window = {700, 500, 3, 4};
    settings.state.display = {2.5f, ToneMap::kFilmic};
    settings.state.automatic_exposure = false;
    settings.state.show.ground = true;
    settings.state.window.recent = {"/a b/x.pnb", "y.exr"};
    EXPECT_TRUE(settings.state.window.hint) << "for who comes first";
    writeSettings(path, settings);
    const ViewSettings read = readSettings(path, problem);
    EXPECT_TRUE(problem.empty()) << problem;
    EXPECT_EQ(read.window.width, 700);
    EXPECT_EQ(read.window.y, 4);
    EXPECT_EQ(read.state.display.exposure, 2.5f);
    EXPECT_FALSE(read.state.automatic_exposure);
    EXPECT_EQ(read.state.display.tone_map, ToneMap::kFilmic);
    EXPECT_TRUE(read.state.show.ground);
    EXPECT_EQ(read.state.window.recent, settings.state.window.recent);
    EXPECT_FALSE(read.state.window.hint);
    std::ofstream(path) << R"({"recent": [1]})";
    EXPECT_TRUE(readSettings(path, problem).state.window.recent.empty());
    EXPECT_NE(problem.find("recent"), std::string::npos) << problem;
    problem.clear();
    std::ofstream(path) << R"({"window": {"width": 1e30}})";
    EXPECT_EQ(readSettings(path, problem).window.width, WindowPlace().width);
    EXPECT_NE(problem.find("width"), std::string::npos) << problem;
    std::filesystem::remove_all(folder);
}

// A place left of the first monitor is a place. What cannot be used is told field by field, and the rest is used.
TEST(ViewSettings, EachFieldStandsForItself) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "each_field.json";
    std::string problem;
    ViewSettings settings;
    EXPECT_FALSE(settings.window.x) << "where the system puts it";
    settings.window.x = -60;
    settings.window.y = -1;
    writeSettings(path, settings);
    EXPECT_EQ(readSettings(path, problem).window.x, -60);
    EXPECT_EQ(readSettings(path, problem).window.y, -1);
    EXPECT_EQ(problem, "");
    writeSettings(path, ViewSettings());
    EXPECT_FALSE(readSettings(path, problem).window.x);
    std::ofstream(path)
        << R"({"window": {"width": 5, "height": 700, "x": "left"}, "speed": 2, "exposure": -1, "ground": 1})";
    const ViewSettings read = readSettings(path, problem);
    EXPECT_EQ(problem, path.string() +
                           ": width is out of range, x is not a number, exposure is out of range, ground is "
                           "neither true nor false; everything else is used");
    EXPECT_EQ(read.window.width, WindowPlace().width);
    EXPECT_EQ(read.window.height, 700);
    EXPECT_FALSE(read.window.x);
    EXPECT_EQ(read.state.playhead.speed, 2);
    EXPECT_EQ(read.state.display.exposure, DisplayTransform().exposure);
    EXPECT_TRUE(read.state.automatic_exposure);
    for (const char* text : {"[1]", "{", "3"}) {
        std::ofstream(path) << text;
        problem.clear();
        EXPECT_EQ(readSettings(path, problem).window.width, WindowPlace().width);
        EXPECT_NE(problem.find("is not used"), std::string::npos) << text;
    }
    std::filesystem::remove(path);
}

TEST(WindowPlace, IsKeptWhereItsUpperEdgeCanBeReached) {
    const std::array<ScreenArea, 2> two = {{{0, 0, 1920, 1080}, {-1280, 100, 1280, 1024}}};
    const std::span<const ScreenArea> one = std::span(two).first(1);
    EXPECT_TRUE(isReachable({-60, -20, 800, 600}, one));
    EXPECT_FALSE(isReachable({-790, 0, 800, 600}, one));
    EXPECT_TRUE(isReachable({-790, 100, 800, 600}, two)) << "on the monitor at the left";
    EXPECT_FALSE(isReachable({100, 1070, 800, 600}, one)) << "below";
    EXPECT_FALSE(isReachable({100, -500, 800, 600}, one)) << "its upper edge is out of reach";
    EXPECT_FALSE(isReachable({0, 0, 800, 600}, {}));
}

TEST(Screenshot, NamesAreFreeAndSafe) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "view_shots";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    EXPECT_EQ(freeScreenshotName(folder).filename(), "view_0001.png");
    std::ofstream(folder / "view_0001.png") << "taken";
    EXPECT_EQ(freeScreenshotName(folder).filename(), "view_0002.png");
    EXPECT_EQ(sequenceName(folder, "../run|1", 12).filename(), "___run_1_0012.png");
}

}  // namespace
}  // namespace penumbra::test_view_scene
