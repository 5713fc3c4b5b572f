#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "fit/light/light_lobes.h"
#include "sh/sh_rotation.h"
#include "sh/zonal.h"
#include "tests/difference.h"
#include "tests/sh/golden.h"

namespace penumbra::test_light_lobes {
namespace {

struct GoldenLight {
    std::string name;
    std::vector<double> sh;
    nlohmann::json expected;
};

std::vector<GoldenLight> goldenLights() {
    std::vector<GoldenLight> lights;
    const nlohmann::json file = readGolden("zh_light_fit.json");
    for (const auto& light : file.at("lights")) {
        GoldenLight golden{light.at("name"), {}, light};
        for (const auto& row : light.at("l"))
            for (double value : row) golden.sh.push_back(value);
        lights.push_back(golden);
    }
    return lights;
}

// Fits one to four lobes to five lights, order 4 RGB. Residuals must be those of the paper within 1e-3; the test prints
// the largest excess.
TEST(LightLobes, GreedyMatchesGolden) {
    Largest worst;
    ASSERT_EQ(goldenLights().size(), 5u);
    for (const GoldenLight& light : goldenLights())
        for (int lobes = 1; lobes <= 4; ++lobes) {
            const LightLobesFit fit = fitLobes(4, light.sh, lobes, LobeFit::kGreedy);
            const double golden = light.expected.at("greedy_residual_1to4").at(std::size_t(lobes - 1));
            EXPECT_LE(fit.residual, golden + 1e-3) << light.name << ", " << lobes << " lobes";
            worst.add(fit.residual - golden);
        }
    std::printf("greedy: largest excess over golden residuals %.2e\n", worst.value());
}

// Checks the axis of the best single lobe and its coefficients, where z_l = sqrt((2l+1)/4pi) times those of
// Nowrouzezahrai 2009 eq 15.
TEST(LightLobes, SingleLobeMatchesGolden) {
    for (const GoldenLight& light : goldenLights()) {
        const LightLobesFit fit = fitLobes(4, light.sh, 1, LobeFit::kJoint);
        const auto& golden = light.expected.at("single_lobe");
        EXPECT_NEAR(std::abs(dot(fit.directions[0], vec3(golden.at("axis")))), 1, 1e-8) << light.name;
        const double sign = dot(fit.directions[0], vec3(golden.at("axis"))) < 0 ? -1 : 1;  // sign of the odd bands
        EXPECT_NEAR(fit.residual, double(golden.at("residual")), 1e-8) << light.name;
        for (std::size_t l = 0; l < 4; ++l)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(fit.coefficients[3 * l + c],
                            std::sqrt((2.0 * double(l) + 1) / (4 * std::numbers::pi)) *
                                double(golden.at("coef_eq15").at(l).at(c)) * (l % 2 ? sign : 1),
                            1e-3)
                    << light.name << " band " << l;
    }
}

// Three lobes fitted together come within 1e-3 of the best that twelve random restarts of the reference found.
TEST(LightLobes, JointReachesBestKnown) {
    for (const GoldenLight& light : goldenLights()) {
        const LightLobesFit fit = fitLobes(4, light.sh, 3, LobeFit::kJoint);
        const double joint = light.expected.at("joint3").at("residual"),
                     best = light.expected.at("joint3").at("best_known");
        EXPECT_LE(fit.residual, best + 1e-3) << light.name;
        const double largest = *std::max_element(fit.coefficients.begin(), fit.coefficients.end(),
                                                 [](double a, double b) { return std::abs(a) < std::abs(b); });
        const double norm = std::sqrt(std::inner_product(light.sh.begin(), light.sh.end(), light.sh.begin(), 0.0));
        std::printf("%-10s joint %.6f (reference %.6f, best known %.6f), irradiance %.6f, largest z %.3g |l|\n",
                    light.name.c_str(), fit.residual, joint, best, fit.irradiance_error, std::abs(largest) / norm);
    }
}

TEST(LightLobes, JointIsNeverWorseThanGreedy) {
    for (const GoldenLight& light : goldenLights())
        for (int lobes : {1, 2, 4, 5, 7})
            EXPECT_LE(fitLobes(4, light.sh, lobes, LobeFit::kJoint).residual,
                      fitLobes(4, light.sh, lobes, LobeFit::kGreedy).residual + 1e-9)
                << light.name << ", " << lobes << " lobes";
}

// 2n-1 fixed directions span every band. Measured errors are 2e-15 at order 4 and at most 1e-14 at order 8.
TEST(LightLobes, FixedDirectionsAreExact) {
    for (const GoldenLight& light : goldenLights()) {
        const LightLobesFit fit = fitLobes(4, light.sh, 0, LobeFit::kFixed);
        EXPECT_EQ(fit.directions.size(), 7u);
        EXPECT_LT(fit.residual, 1e-12) << light.name;
    }
    for (int order = 1; order <= kMaxOrder; ++order) {
        std::vector<double> sh;
        for (int i = 0; i < 3 * coefficientCount(order); ++i) sh.push_back(std::sin(1.7 * i + 0.3));
        const LightLobesFit fit = fitLobes(order, sh, 0, LobeFit::kFixed);
        EXPECT_EQ(int(fit.directions.size()), fixedLobeCount(order));
        EXPECT_LT(fit.residual, 1e-12) << order;
        const double largest = *std::max_element(fit.coefficients.begin(), fit.coefficients.end());
        EXPECT_LT(largest, 4 * std::sqrt(std::inner_product(sh.begin(), sh.end(), sh.begin(), 0.0))) << order;
    }
}

// A light that is a sum of two lobes comes back as two lobes, at any orientation.
TEST(LightLobes, SumOfTwoLobesComesBack) {
    const std::vector<Vec3d> axes = {normalized(Vec3d{1, 2, -0.5}), normalized(Vec3d{-0.3, 0.1, -1})};
    const std::vector<double> bright = {1, 1.5, 1.4, 1.1, 0.6}, wide = {0.8, 0.7, 0.2, 0, -0.1};
    std::vector<double> sh(75, 0.0), one(25);
    for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 2; ++d) {
            rotateZonal(d == 0 ? bright : wide, axes[std::size_t(d)], one);
            for (std::size_t i = 0; i < 25; ++i)
                sh[3 * i + std::size_t(c)] += (1 + 0.5 * c * (d == 0 ? 1 : -1)) * one[i];
        }
    const LightLobesFit fit = fitLobes(5, sh, 2, LobeFit::kJoint);
    EXPECT_LT(fit.residual, 1e-6);
    EXPECT_NEAR(dot(fit.directions[0], axes[0]), 1, 1e-9);
    EXPECT_NEAR(dot(fit.directions[1], axes[1]), 1, 1e-9);
}

TEST(LightLobes, BandZeroOnlyAndBlackAreExact) {
    for (LobeFit how : {LobeFit::kGreedy, LobeFit::kJoint, LobeFit::kFixed})
        for (double value : {0.0, 2.5}) {
            std::vector<double> sh(48, 0.0);
            sh[0] = value, sh[1] = 2 * value;
            const LightLobesFit fit = fitLobes(4, sh, 3, how);
            EXPECT_LT(fit.residual, 1e-12);
            for (double z : fit.coefficients) EXPECT_TRUE(std::isfinite(z));
            for (Vec3d s : fit.directions) EXPECT_NEAR(length(s), 1, 1e-12);
        }
}

TEST(LightLobes, SameLobesEveryTime) {
    const GoldenLight light = goldenLights()[2];
    const LightLobesFit a = fitLobes(4, light.sh, 3, LobeFit::kJoint), b = fitLobes(4, light.sh, 3, LobeFit::kJoint);
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_EQ(a.directions, b.directions);
}

// Measures the calling thread alone, so that other work on the machine does not count.

}  // namespace
}  // namespace penumbra::test_light_lobes
