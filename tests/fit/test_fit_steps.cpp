// Slices at steps of a parameter: what lies between two steps, and where the steps stand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/reflectance/fit_steps.h"
#include "fit/reflectance/shading_error.h"
#include "tests/difference.h"

namespace penumbra::test_fit_steps {
namespace {

// Returns the slices of one value from the steps about it, which must enclose it: [J^2, E, 3].
std::vector<double> interpolatedSlices(const BrdfSteps& steps, double value) {
    const std::vector<double>& at = steps.values;
    assert(value >= at.front() && value <= at.back());
    const auto high = std::size_t(std::upper_bound(at.begin() + 1, at.end() - 1, value) - at.begin());
    const double t = (value - at[high - 1]) / (at[high] - at[high - 1]);
    const std::size_t size = steps.slices.size() / at.size();
    std::vector<double> slices(size);
    for (std::size_t i = 0; i < size; ++i)
        slices[i] = std::lerp(steps.slices[(high - 1) * size + i], steps.slices[high * size + i], t);
    return slices;
}

struct Case {
    const char* text;
    std::size_t steps;  // steps that the default error needs
};

// The error that steps state is that of their middles. Elsewhere it is at most a fifth larger: measured at eight places
// of every interval, where the largest was 1.02 times the stated error. The numbers of steps are those of the first
// fit.
TEST(FitSteps, StateTheErrorBetweenThem) {
    for (const auto& [text, count] : {Case{"ggx:alpha=0.1..0.6", 16}, Case{"phong:exponent=1..100", 19},
                                      Case{"ward-gmd:ax=0.2,ay=0.15..0.6", 9}, Case{"oren-nayar:sigma=0..1.2", 9}}) {
        const BrdfRange range = *parseBrdfRange(text);
        const BrdfSteps steps = fitSteps(range, {}, int(kMaxBrdfSteps), 2);
        EXPECT_LE(steps.error, kMaxStepError) << text;
        EXPECT_EQ(steps.values.size(), count) << text;
        EXPECT_EQ(steps.values.front(), range.least);
        EXPECT_EQ(steps.values.back(), range.most);
        EXPECT_TRUE(std::ranges::find(steps.values, (range.least + range.most) / 2) != steps.values.end());
        Largest worst;
        for (std::size_t s = 0; s + 1 < steps.values.size(); s += 4)
            for (int k = 1; k < 8; ++k) {
                const double value = std::lerp(steps.values[s], steps.values[s + 1], k / 8.0);
                const BrdfFile exact = fitBrdf(sumBrdf(sumAt(range, value)), {}, 2);
                worst.add(relativeDifference(interpolatedSlices(steps, value), exact.slices));
            }
        EXPECT_LT(worst, 1.2 * steps.error) << text;
        RecordProperty("worst", std::to_string(worst));
    }
}

TEST(FitSteps, AreExactAtEveryStep) {
    const BrdfRange range = *parseBrdfRange("ggx:alpha=0.2..0.4,color=1/0.5/0.25");
    const BrdfSteps steps = fitSteps(range, {3, 3}, 3, 1);
    ASSERT_EQ(steps.values.size(), 3u);
    for (const double value : steps.values) {
        const std::vector<double> exact = fitBrdf(sumBrdf(sumAt(range, value)), {3, 3}, 1).slices;
        EXPECT_EQ(interpolatedSlices(steps, value), exact) << value;
    }
    EXPECT_GT(steps.error, kMaxStepError) << "three steps are too few, and it is said";
}

// The picture decides: between two steps it is as far from brute force as at a step.
TEST(FitSteps, ShadeAsWellBetweenAsAtThem) {
    const BrdfRange range = *parseBrdfRange("ggx:alpha=0.1..0.6");
    const BrdfSteps steps = fitSteps(range, {}, int(kMaxBrdfSteps), 2);
    for (const std::size_t s : {std::size_t(0), steps.values.size() / 2}) {
        const double value = (steps.values[s] + steps.values[s + 1]) / 2;
        const RgbBrdf brdf = sumBrdf(sumAt(range, value));
        BrdfFile exact = fitBrdf(brdf, {}, 2), between = exact;
        between.slices = interpolatedSlices(steps, value);
        const ShadingTruth truth = shadingTruth(brdf, 2);
        measureShading(truth, exact);
        measureShading(truth, between);
        EXPECT_NEAR(between.errors.at("shading_d5"), exact.errors.at("shading_d5"), 1e-3) << value;
    }
}

}  // namespace
}  // namespace penumbra::test_fit_steps
