#pragma once
// From the fits of a comparison to series of plots: what the figures share.
#include <functional>
#include <string>
#include <vector>

#include "fit/compare/compare_figures.h"

namespace penumbra {

using Measure = std::function<double(const CompareFit&)>;
double heldOutError(const CompareFit& fit);
double heldOutAmbient(const CompareFit& fit);
double trainError(const CompareFit& fit);

std::string fixedNumber(double value, int digits);  // "-" when not finite
std::string percent(double share);                  // "12.3%"

// A colour a model; dashed or hollow for angles, the papers' features.
SeriesStyle styleOf(ModelKind model, FeatureKind features);

// Fits that differ in one number: fit i stands at x[i].
struct Sweep {
    std::vector<double> x;
    std::function<void(FitOptions&, std::size_t)> vary;
};
// One series for each model on each of the features.
std::vector<Series> sweepSeries(const Comparison& comparison, const Sweep& sweep, const Measure& measure);

// Fits that differ in kind: a group of bars for each model, in it a bar for each variant on each of the features.
struct Variant {
    std::string name;
    std::function<void(FitOptions&)> change;  // of the reference
    Measure measure;
};
Plot variantPlot(const Comparison& comparison, const std::vector<Variant>& variants);

struct Lowest {
    const Series* series = nullptr;  // null: there is no finite point
    double x = 0, y = 0;
};
Lowest lowestPoint(const std::vector<Series>& series);

}  // namespace penumbra
