// Zonal lobes of visibility (paper 003, section 3.1).
#include <gtest/gtest.h>

#include <cmath>

#include "fit/compare/lobe_models.h"
#include "fit/light/light_lobes.h"
#include "tests/fit/synthetic_character.h"
#include "tests/sh/golden.h"

namespace penumbra {
namespace {

std::vector<double> grey(const std::vector<double>& numbers) {
    std::vector<double> sh;
    for (const double number : numbers) sh.insert(sh.end(), 3, number);
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

// The character's visibility has so few bands that one lobe has all of it. Every model has errors that are finite.
TEST(VisibilityLobes, AreComparedWithSh) {
    const synthetic::TemporaryFile file("lobes.vis.h5");
    synthetic::writeCharacter(file.path, {});
    const VisibilityReader reader(file.path);
    const PoseTable poses = readPoses(reader, 2);
    CompareOptions options;
    options.clusters = {2};
    options.conventions = {parseConvention("A3")};
    options.holdout = {"clip1"};
    options.lobes = {1, 2};
    options.threads = 2;
    const CompareInput input{reader, poses, "lobes.vis.h5"};
    const LobeComparison found = compareLobes(input, prepareCharacter(input, options), options, {});
    ASSERT_EQ(found.models.size(), 4u);
    EXPECT_LE(found.vertices, kLobeVertices);
    EXPECT_TRUE(std::isnan(found.models[1].visibility.mean));
    EXPECT_LT(found.models[2].fitted, 0.02) << "what the ridge leaves";
    for (const LobeModel& model : found.models) {
        EXPECT_TRUE(std::isfinite(model.cosine.mean) && model.cosine.mean > 0) << model.name;
        EXPECT_GE(model.cosine.deviation, 0) << model.name;
    }
}

}  // namespace
}  // namespace penumbra
