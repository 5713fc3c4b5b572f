#pragma once
// Turns the fits of a comparison into series of plots. All figures share these functions.
#include <functional>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_figures.h"

namespace penumbra {

using Measure = std::function<double(const CompareFit&)>;
double heldOutError(const CompareFit& fit);
double heldOutAmbient(const CompareFit& fit);
double trainError(const CompareFit& fit);

std::string fixedNumber(double value, int digits);  // "-" when not finite
std::string percent(double share);                  // for example "12.3%"

// Returns the style of a model's series. Each model has a colour; series of angles, the papers' features, are dashed or
// hollow.
SeriesStyle styleOf(ModelKind model, FeatureKind features);
// The same for feature vectors; the linear and the quadratic one have the colours of these models.
std::string labelOf(const VectorFit& fit);
SeriesStyle styleOf(const VectorFit& fit);

// The shares of a decay down to 1e-7, with marks where they are few.
Series decaySeries(const EigenvalueDecay& decay, int colour);
// Returns how many components have that share of the variance, "> 200" where the known ones do not.
std::string componentsText(const EigenvalueDecay& decay, double share);
// A row for each decay, and a column for each share.
Table decayTable(const std::vector<EigenvalueDecay>& decays, const std::vector<double>& shares);

// Returns all fits at the reference, model by model and for each model features by features.
std::vector<const CompareFit*> referenceFits(const Comparison& comparison);

// Fits that differ in one number; fit i stands at x[i].
struct Sweep {
    std::vector<double> x;
    std::function<void(FitOptions&, std::size_t)> vary;
};
// Returns one series for each model on each of the features.
std::vector<Series> sweepSeries(const Comparison& comparison, const Sweep& sweep, const Measure& measure);

// The axis of relative errors. It is logarithmic where one model is so far off that the others would lie on one
// another.
Axis errorAxis(const std::vector<Series>& series);

// Fits that differ in kind. The plot has a group of bars for each model, and in it a bar for each variant on each of
// the features.
struct Variant {
    std::string name;
    std::function<void(FitOptions&)> change;  // changes the reference
    Measure measure;
};
struct PlotName {
    std::string id, title, y_label;
};
Plot variantPlot(const Comparison& comparison, const PlotName& name, const std::vector<Variant>& variants);

struct Lowest {
    const Series* series = nullptr;  // null when there is no finite point
    double x = 0, y = 0;
};
// Returns the lowest point of all series.
Lowest lowestPoint(const std::vector<Series>& series);

}  // namespace penumbra
