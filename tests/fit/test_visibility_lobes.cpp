// Zonal lobes of visibility (Nowrouzezahrai 2008, section 3.1).
#include <gtest/gtest.h>

#include <cmath>

#include "fit/light/light_lobes.h"
#include "fit/papers/compare/lobe_models.h"
#include "fit/papers/lobes/fit_lobe_model.h"
#include "tests/fit/synthetic_character.h"
#include "tests/sh/golden.h"

namespace penumbra::test_visibility_lobes {
namespace {

std::vector<double> grey(const std::vector<double>& values) {
    std::vector<double> sh;
    for (const double number : values) sh.insert(sh.end(), 3, number);
    return sh;
}

// Six occluders, visibility of order 4 that is 0 below the horizon. The golden file asks for its residuals plus 2e-3.
TEST(VisibilityLobes, ResidualsAreThoseOfTheGoldenFile) {
    const auto golden = readGolden("zh_vis_fit.json");
    for (const auto& test : golden.at("cases")) {
        const std::vector<double> sh = grey(doubles(test.at("v")));
        for (const auto& [how, name] : {std::pair(LobeFit::kGreedy, "greedy"), {LobeFit::kJoint, "joint"}})
            for (int lobes = 1; lobes <= 3; ++lobes)
                EXPECT_LE(fitLobes(4, sh, lobes, how).residual,
                          test.at(name)[std::size_t(lobes - 1)].get<double>() + golden.at("tol").get<double>())
                    << test.at("kind") << " " << name << " " << lobes;
    }
}

// Lobes that start from those of a near visibility keep their order and their signs, and are no worse than fresh ones.
TEST(VisibilityLobes, FollowANearVisibility) {
    const auto golden = readGolden("zh_vis_fit.json");
    for (const auto& test : golden.at("cases")) {
        const std::vector<double> sh = grey(doubles(test.at("v")));
        const LightLobesFit start = fitLobes(4, sh, 2, LobeFit::kJoint);
        std::vector<double> near = sh;
        for (std::size_t i = 0; i < near.size(); ++i) near[i] += 0.01 * std::sin(double(i / 3));
        const LightLobesFit followed = fitLobesFrom(4, near, start.directions, 1e-8);
        EXPECT_LE(followed.residual, start.residual + 0.02);
        for (std::size_t d = 0; d < 2; ++d)
            EXPECT_GT(dot(followed.directions[d], start.directions[d]), 0.9) << test.at("kind");
        const LightLobesFit same = fitLobesFrom(4, sh, start.directions, 1e-8);
        EXPECT_NEAR(same.residual, start.residual, 1e-6);
    }
}

// A large ridge leaves the coefficients where it pulls them, and none leaves the best fit.
TEST(VisibilityLobes, RidgePullsToTheGivenCoefficients) {
    const auto golden = readGolden("zh_vis_fit.json");
    const std::vector<double> sh = grey(doubles(golden.at("cases")[0].at("v")));
    const LightLobesFit start = fitLobes(4, sh, 2, LobeFit::kJoint);
    std::vector<double> given = start.coefficients;
    for (std::size_t i = 0; i < given.size(); ++i) given[i] += 0.1 * std::cos(double(i / 3));
    const LightLobesFit held = fitLobesFrom(4, sh, start.directions, 1e6, given),
                        free = fitLobesFrom(4, sh, start.directions, 1e-8, given);
    for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(held.coefficients[i], given[i], 1e-4);
    EXPECT_NEAR(free.residual, start.residual, 1e-5);
    EXPECT_GT(held.residual, free.residual + 1e-3);
    // Black light has nothing to scale by.
    const LightLobesFit black = fitLobesFrom(4, std::vector<double>(48), start.directions, 1e6, given);
    for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(black.coefficients[i], given[i], 1e-4);
}

TEST(VisibilityLobes, ChartGivesBackDirections) {
    for (const Vec3 axis : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0.6f, -0.64f, 0.48f}}) {
        const LobeChart chart(axis);
        for (const auto& [u, v] : {std::pair(0.0, 0.0), {0.3, -0.2}, {-1.5, 2.0}}) {
            const std::array<double, 2> place = chart.of(chart.at(u, v));
            EXPECT_NEAR(place[0], u, 1e-6);
            EXPECT_NEAR(place[1], v, 1e-6);
        }
    }
}

// One lobe whose axis and coefficients are linear in two inputs is found, and so is the map. What is left comes from
// the ridge: measured 3e-4.
TEST(VisibilityLobes, ALobeThatMovesWithThePoseIsLearned) {
    constexpr std::size_t kFrames = 24;
    const Vec3 axis{0.48f, 0.36f, 0.8f};
    Matrix inputs(kFrames, 2);
    MatrixF visibility(kFrames, 16);
    std::vector<std::size_t> all;
    std::vector<double> sh(16);
    for (std::size_t f = 0; f < kFrames; ++f) {
        all.push_back(f);
        inputs(f, 0) = std::sin(0.9 * double(f));
        inputs(f, 1) = std::cos(0.7 * double(f));
        const double a = inputs(f, 0), b = inputs(f, 1);
        lobesToVisibility(4, std::span(&axis, 1),
                          std::array{0.2 * a, 0.15 * b, 2 + 0.1 * b, 1.5 - 0.1 * a, 0.7 + 0.05 * a, 0.2}, sh);
        for (std::size_t i = 0; i < 16; ++i) visibility(f, i) = float(sh[i]);
    }
    const LobeMaps maps = fitLobeMaps({4, 1, 1e-6, all}, visibility, inputs, 1);
    EXPECT_LT(std::sqrt(maps.error / maps.squares), 1e-4);
    const Matrix predicted = predictLobes(4, 1, maps, inputs, all, 1);
    double error = 0, squares = 0;
    for (std::size_t i = 0; i < predicted.values.size(); ++i) {
        const double truth = double(visibility.values[i]);
        error += (predicted.values[i] - truth) * (predicted.values[i] - truth);
        squares += truth * truth;
    }
    EXPECT_LT(std::sqrt(error / squares), 5e-3);
}

// The character's visibility has so few bands that one lobe has all of it. Every model has errors that are finite.
// A character of fewer vertices than a sample has, so that a comparison is of all.
synthetic::Options smallCharacter() {
    synthetic::Options options;
    options.rings = 4;
    options.sides = 5;
    options.frames_per_clip = 6;
    options.convention = {BelowHorizon::kBlocked, 5};
    return options;
}

TEST(VisibilityLobes, AreComparedWithSh) {
    const synthetic::TemporaryFile file("lobes.vis.h5");
    synthetic::Options character = smallCharacter();
    character.convention = synthetic::Options().convention;  // of few bands, which two lobes follow
    synthetic::writeCharacter(file.path, character);
    const VisibilityReader reader(file.path);
    const PoseTable poses = readPoses(reader, {.threads = 2});
    CompareOptions options;
    options.clusters = {2};
    options.conventions = {parseConvention("A3")};
    options.holdout = {"clip1"};
    options.lobes = {1, 2};
    options.threads = 2;
    const CompareInput input{reader, poses, "lobes.vis.h5"};
    const LobeComparison found = compareLobes(input, prepareCharacter(input, options), options, {});
    ASSERT_EQ(found.models.size(), 4u);
    EXPECT_LE(found.vertices, kLobeSample);
    EXPECT_TRUE(std::isnan(found.models[1].visibility.mean));
    EXPECT_LT(found.models[2].fitted, 0.02) << "what the ridge leaves";
    for (const ComparedLobes& model : found.models) {
        EXPECT_TRUE(std::isfinite(model.cosine.mean) && model.cosine.mean > 0) << model.name;
        EXPECT_GE(model.cosine.deviation, 0) << model.name;
    }
}

// Returns the error of predicted moments over the frames of one clip. It is the same in every frame of reference.
FrameSpread spreadOfFile(const VisibilityReader& truth, const VisibilityReader& predicted, std::uint16_t clip) {
    const FrameList& list = truth.header().frames;
    const std::size_t n = predicted.header().coefficientCount(), stride = truth.header().coefficientCount();
    FrameSquares squares{std::vector<double>(list.frameCount()), std::vector<double>(list.frameCount())};
    std::vector<std::size_t> frames;
    for (std::size_t f = 0; f < list.frameCount(); ++f) {
        if (list.clip[f] != clip) continue;
        frames.push_back(f);
        const std::vector<float> a = truth.readFrame(f).coefficients, b = predicted.readFrame(f).coefficients;
        for (std::size_t v = 0; v < truth.header().mesh.vertexCount(); ++v)
            for (std::size_t i = 0; i < n; ++i) {
                const double number = double(a[v * stride + i]), difference = double(b[v * n + i]) - number;
                squares.error[f] += difference * difference;
                squares.truth[f] += number * number;
            }
    }
    return spreadOver(squares, frames);
}

// What `visibility --model zh-lobes` writes and `predict` reads back has the errors that `compare` shows.
TEST(VisibilityLobes, AFileHasTheErrorsOfTheComparison) {
    const synthetic::TemporaryFile file("lobes.vis.h5"), model_file("lobes.lobes.h5"), predicted_file("lobes.pred.h5");
    synthetic::writeCharacter(file.path, smallCharacter());
    const VisibilityReader reader(file.path);
    const PoseTable poses = readPoses(reader, {.threads = 2});
    CompareOptions options;
    options.clusters = {3};
    options.conventions = {parseConvention("A4")};
    options.holdout = {"clip1"};
    options.lobes = {1, 2};
    options.threads = 2;
    const CompareInput input{reader, poses, "lobes.vis.h5"};
    const LobeComparison found = compareLobes(input, prepareCharacter(input, options), options, {});
    ASSERT_EQ(found.vertices, 20u);
    for (int lobes = 1; lobes <= 2; ++lobes) {
        LobeFitOptions fit_options;
        fit_options.lobes = lobes;
        fit_options.clusters = 3;
        fit_options.holdout = options.holdout;
        fit_options.threads = 2;
        LobeModelFit fit = fitLobeModel(reader, fit_options, {});
        fit.model.provenance = {"test", "0", "{}", {}};
        writeLobes(model_file.path, fit.model);
        const LobeModel model = readLobes(model_file.path);
        predictFile(model, reader, {predicted_file.path, {"test", "0", "{}", {}}, 2});
        const FrameSpread of_file = spreadOfFile(reader, VisibilityReader(predicted_file.path), 1);
        const ComparedLobes& compared = found.models[std::size_t(lobes) + 1];
        EXPECT_EQ(model.ridge, compared.ridge);
        EXPECT_NEAR(fit.report.fitted, compared.fitted, 1e-9);
        EXPECT_NEAR(fit.report.held_out_spread.mean, compared.visibility.mean, 1e-9);
        EXPECT_NEAR(of_file.mean, compared.visibility.mean, 1e-6) << lobes;
        EXPECT_NEAR(of_file.deviation, compared.visibility.deviation, 1e-6) << lobes;
    }
}

TEST(VisibilityLobes, OfNothingAreNothing) {
    const synthetic::TemporaryFile file("lobes.vis.h5");
    synthetic::Options character = smallCharacter();
    character.blocked = true;
    synthetic::writeCharacter(file.path, character);
    LobeFitOptions options;
    options.clusters = 3;
    options.lobes = 3;
    const VisibilityReader reader(file.path);
    const LobeModelFit fit = fitLobeModel(reader, options, {});
    for (const float number : predictLobeValues(fit.model, reader.readFrame(3).pose, 1)) EXPECT_NEAR(number, 0, 1e-9);
    EXPECT_EQ(fit.report.train_spread.mean, 0);
}

}  // namespace
}  // namespace penumbra::test_visibility_lobes
