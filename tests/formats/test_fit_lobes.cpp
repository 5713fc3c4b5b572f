#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/brdf/fit_lobes.h"

namespace penumbra::test_fit_lobes {
namespace {

RgbBrdf sumOf(std::vector<BrdfLobe> lobes) {
    return {"sum", BrdfSymmetry::kIsotropic, [lobes = std::move(lobes)](Vec3d wi, Vec3d wo) {
                return toDouble(evalLobes(lobes, toFloat(wi), toFloat(wo)));
            }};
}

BrdfLobe lobe(const char* text) { return lobeOf(parseBrdf(text)); }

// The widths and Fresnel terms of the material are on the grid of the fit, so only the colours are left to find.
TEST(FitLobes, FindsTheLobesOfASum) {
    const std::vector<BrdfLobe> truth = {lobe("lambert:color=0.2/0.3/0.4"),
                                         lobe("ggx:alpha=0.01,f0=0.04,color=1/0.5/1"),
                                         lobe("ggx:alpha=1,f0=1,color=0.1/0.2/0.1")};
    const std::vector<BrdfLobe> found = fitLobes(samplesOf(sumOf(truth)));
    ASSERT_EQ(found.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(found[i].model, truth[i].model);
        EXPECT_NEAR(found[i].parameters[0], truth[i].parameters[0], 1e-6);
        EXPECT_NEAR(found[i].parameters[1], truth[i].parameters[1], 1e-6);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[i].color[c], truth[i].color[c], 0.01) << i;
    }
}

TEST(FitLobes, MatteMaterialsAreOneLobe) {
    const std::vector<BrdfLobe> found = fitLobes(samplesOf(sumOf({lobe("lambert:color=0.2/0.3/0.4")})));
    Vec3 specular;
    for (const BrdfLobe& l : found)
        if (l.model != BrdfModel::kLambert) specular += l.color;
    EXPECT_LT(length(specular), 1e-3);
    EXPECT_NEAR(found[0].color.y, 0.3, 1e-3);
}

TEST(FitLobes, NothingToFitGivesABlackLobe) {
    for (const std::vector<BrdfSample>& samples :
         {std::vector<BrdfSample>{}, std::vector<BrdfSample>(20, {{0, 0, 1}, {0, 0, 1}, {0, 0, 0}})}) {
        const std::vector<BrdfLobe> found = fitLobes(samples);
        ASSERT_EQ(found.size(), 1u);
        EXPECT_EQ(found[0].color, Vec3{});
        EXPECT_TRUE(isValid(found[0]));
    }
}

// D falls to a half there.
TEST(FitLobes, HalfWidthIsThatOfTheDistribution) {
    EXPECT_NEAR(halfWidth(lobe("ggx:alpha=1")), std::numbers::pi / 2, 1e-6);
    for (double alpha : {0.01, 0.3, 0.8}) {
        const double w = halfWidth({BrdfModel::kGgx, {float(alpha), 1}, {1, 1, 1}});
        const auto d = [&](double c) { return 1 / std::pow(c * c * (alpha * alpha - 1) + 1, 2); };
        EXPECT_NEAR(d(std::cos(w)) / d(1), 0.5, 1e-6) << alpha;
    }
}

}  // namespace
}  // namespace penumbra::test_fit_lobes
