// Checks the compact forms of slices: how many numbers each has, which symmetry it has, and that it keeps all that the
// symmetry leaves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "sh/brdf/slice_form.h"
#include "tests/sh/eval_slice.h"

namespace penumbra::test_slice_form {
namespace {

constexpr SliceForm kForms[] = {SliceForm::kGeneral, SliceForm::kOrthotropic, SliceForm::kIsotropic};
constexpr std::array<int, 2> kOrders[] = {{5, 5}, {1, 1}, {1, 4}, {4, 1}, {3, 6}, {8, 2}, {8, 8}};  // J, view order

std::vector<float> randomCoefficients(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    std::vector<float> coefficients(count);
    for (float& x : coefficients) x = normal(random);
    return coefficients;
}

// Returns y(wi)^T C y_even(wo).
double valueOf(std::span<const float> slices, int j, int view, Vec3 wi, Vec3 wo) {
    std::vector<float> f(std::size_t(coefficientCount(j))), y(f.size());
    evalSlice(slices, j, view, wo, f);
    evalBasis(j, wi, y);
    double sum = 0;
    for (std::size_t i = 0; i < f.size(); ++i) sum += double(f[i]) * y[i];
    return sum;
}

Vec3 turned(Vec3 w, double phi) {
    const float c = float(std::cos(phi)), s = float(std::sin(phi));
    return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}

TEST(SliceForm, CountsAreThoseOfTheSymmetries) {
    EXPECT_EQ(entryCount(SliceForm::kIsotropic, 5, 5), 32u);
    EXPECT_EQ(entryCount(SliceForm::kOrthotropic, 5, 5), 102u);
    EXPECT_EQ(entryCount(SliceForm::kGeneral, 5, 5), 375u);
    EXPECT_EQ(entryCount(SliceForm::kIsotropic, 4, 5), 23u);  // m = 0: 4 * 3, 1: 3 * 2, 2: 2 * 2, 3: 1 * 1
    for (const auto [j, view] : kOrders)
        EXPECT_EQ(entryCount(SliceForm::kGeneral, j, view), std::size_t(j * j * view * (view + 1) / 2));
    for (const SliceForm form : kForms) EXPECT_EQ(entryCount(form, 1, 1), 1u);
}

// For any C, a form keeps the mean of C over the symmetries. So it has the symmetries, and no number is missing. 20
// equal steps stand for all turns; that is exact for |m| + |M| < 20, and the largest orders have 14.
TEST(SliceForm, KeepsTheMeanOverTheSymmetries) {
    using Map = std::function<Vec3(Vec3)>;
    const Map mirror_x =
                  [](Vec3 w) {
                      return Vec3{-w.x, w.y, w.z};
                  },
              mirror_y = [](Vec3 w) {
                  return Vec3{w.x, -w.y, w.z};
              };
    const std::vector<Map> mirrors = {[](Vec3 w) { return w; }, mirror_x, mirror_y,
                                      [&](Vec3 w) { return mirror_x(mirror_y(w)); }};
    std::vector<Map> turns;
    for (int k = 0; k < 20; ++k)
        for (const double sign : {1.0, -1.0})
            turns.push_back([k, sign](Vec3 w) {
                return turned({w.x, float(sign) * w.y, w.z}, 2 * std::numbers::pi * k / 20);
            });
    const Vec3 wi = normalized(Vec3{0.5f, -0.3f, 0.7f}), wo = normalized(Vec3{0.2f, 0.9f, 0.4f});
    for (const auto [j, view] : kOrders) {
        const std::vector<float> any = randomCoefficients(entryCount(SliceForm::kGeneral, j, view), 7);
        for (const SliceForm form : {SliceForm::kOrthotropic, SliceForm::kIsotropic}) {
            const std::vector<Map>& maps = form == SliceForm::kIsotropic ? turns : mirrors;
            double mean = 0;
            for (const Map& map : maps) mean += valueOf(any, j, view, map(wi), map(wo)) / double(maps.size());
            const std::vector<float> kept = expandSlices(form, j, view, compactSlices(form, j, view, any));
            EXPECT_NEAR(valueOf(kept, j, view, wi, wo), mean, 1e-6)  // measured 2.5e-7
                << nameOf(form) << " J " << j << " view order " << view;
        }
    }
}

TEST(SliceForm, CompactNumbersComeBackBitForBit) {
    for (const auto [j, view] : kOrders)
        for (const SliceForm form : kForms) {
            const std::vector<float> entries = randomCoefficients(3 * entryCount(form, j, view), 3);
            const std::vector<float> slices = expandSlices(form, j, view, entries);
            EXPECT_EQ(slices.size(), 3 * entryCount(SliceForm::kGeneral, j, view));
            EXPECT_EQ(compactSlices(form, j, view, slices), entries) << nameOf(form) << " " << j << " " << view;
            const SliceForm found = mostCompactForm(j, view, slices);
            EXPECT_LE(entryCount(found, j, view), entries.size() / 3);
            EXPECT_EQ(expandSlices(found, j, view, compactSlices(found, j, view, slices)), slices);
        }
}

TEST(SliceForm, MostCompactOneThatHoldsWithinTheTolerance) {
    constexpr int kOrder = 5;
    for (const SliceForm form : kForms) {
        const std::vector<float> entries = randomCoefficients(3 * entryCount(form, kOrder, kOrder), 5);
        EXPECT_EQ(mostCompactForm(kOrder, kOrder, expandSlices(form, kOrder, kOrder, entries)), form);
    }
    std::vector<float> slices(2 * 375, 0.0f);
    EXPECT_EQ(mostCompactForm(kOrder, kOrder, slices), SliceForm::kIsotropic);
    slices[0] = 100;
    // Changes in the other channel: first at a place that only orthotropic materials have, (1, 1) with (3, 3), then at
    // one that neither form has.
    const std::vector<int> even = evenIndices(kOrder);
    const auto place = [&](int index, int view_index) {
        return 375 + std::size_t(index) * even.size() +
               std::size_t(std::find(even.begin(), even.end(), view_index) - even.begin());
    };
    const std::size_t ortho = place(shIndex(1, 1), shIndex(3, 3)), none = place(shIndex(1, 1), shIndex(0, 0));
    const auto formWith = [&](std::size_t at, float value) {
        std::vector<float> changed = slices;
        changed[at] = value;
        return mostCompactForm(kOrder, kOrder, changed);
    };
    EXPECT_EQ(formWith(ortho, 9e-5f), SliceForm::kIsotropic);
    EXPECT_EQ(formWith(ortho, 1.1e-4f), SliceForm::kOrthotropic);
    EXPECT_EQ(formWith(none, 9e-5f), SliceForm::kIsotropic);
    EXPECT_EQ(formWith(none, 1.1e-4f), SliceForm::kGeneral);
    EXPECT_EQ(formWith(none, std::numeric_limits<float>::quiet_NaN()), SliceForm::kGeneral);
    // The entry of +m changes without that of -m.
    EXPECT_EQ(formWith(place(shIndex(1, 1), shIndex(1, 1)), 1.0f), SliceForm::kOrthotropic);
}

}  // namespace
}  // namespace penumbra::test_slice_form
