// Chooses the steps of a parameter.
//
// Problem: slices bend sharply where a lobe is narrow and hardly change where it is wide. Steps of equal width that are
// dense enough for the narrow end waste most of the others.
//
// Here: the widest error is halved again and again. Each interval has the exact slices of its middle, which tell its
// error. The interval with the largest error is cut there, so that no fit is made twice.
#include "fit/reflectance/fit_steps.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fit/numerics/matrix.h"

namespace penumbra {

namespace {

struct Step {
    double value;
    std::vector<double> slices;
};

// The interval that ends at a step, with the exact slices of its middle.
struct Interval {
    Step middle;
    double error;  // relative error of interpolation there
};

// Slices belong to orthonormal functions of the incident and of the outgoing direction, so the norm of a difference is
// that of the functions.
double errorOf(const Step& low, const Step& high, const Step& middle) {
    RelativeRms error;
    for (std::size_t i = 0; i < middle.slices.size(); ++i)
        error.add((low.slices[i] + high.slices[i]) / 2, middle.slices[i]);
    return error.value();
}

}  // namespace

BrdfSteps fitSteps(const BrdfRange& range, const SliceOrders& orders, int most_steps, int threads) {
    assert(most_steps >= 3);
    const auto fit = [&](double value) {
        const RgbBrdf brdf = sumBrdf(sumAt(range, value));
        return Step{value, fitSlices(settledSlices(brdf, orders.slice_order, threads), orders)};
    };
    const auto interval = [&](const Step& low, const Step& high) {
        Step middle = fit((low.value + high.value) / 2);
        const double error = errorOf(low, high, middle);
        return Interval{std::move(middle), error};
    };
    // 1. The ends and the middle, where the material starts.
    std::vector<Step> steps = {fit(range.least), fit((range.least + range.most) / 2), fit(range.most)};
    std::vector<Interval> between = {interval(steps[0], steps[1]), interval(steps[1], steps[2])};
    const auto worst = [&] {
        return std::ranges::max_element(between, {}, [](const Interval& of) { return of.error; }) - between.begin();
    };
    // 2. Cut the worst interval in its middle.
    while (int(steps.size()) < most_steps && between[std::size_t(worst())].error > kMaxStepError) {
        const std::ptrdiff_t cut = worst();
        steps.insert(steps.begin() + cut + 1, std::move(between[std::size_t(cut)].middle));
        const auto at = steps.begin() + cut;
        between[std::size_t(cut)] = interval(at[0], at[1]);
        between.insert(between.begin() + cut + 1, interval(at[1], at[2]));
    }
    BrdfSteps all;
    all.parameter = range.parameter;
    all.lobes = range.terms;
    all.error = between[std::size_t(worst())].error;
    for (const Step& step : steps) {
        all.values.push_back(step.value);
        all.slices.insert(all.slices.end(), step.slices.begin(), step.slices.end());
    }
    return all;
}

}  // namespace penumbra
