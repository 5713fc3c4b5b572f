#include "fit/papers/compare/compare_series.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace penumbra {

double heldOutError(const CompareFit& fit) { return fit.report.held_out.relative_error; }
double heldOutAmbient(const CompareFit& fit) { return fit.report.held_out.ambient_error; }
double trainError(const CompareFit& fit) { return fit.report.train.relative_error; }

std::string fixedNumber(double value, int digits) {
    if (!std::isfinite(value)) return "-";
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
    return buffer;
}

std::string percent(double share) { return fixedNumber(100 * share, 1) + "%"; }

SeriesStyle styleOf(ModelKind model, FeatureKind features) {
    const auto at = std::find(kModelKinds.begin(), kModelKinds.end(), model) - kModelKinds.begin();
    return {int(at) % kPlotColours, features != FeatureKind::kRelativeBones};
}

std::string labelOf(const VectorFit& fit) {
    return std::string(nameOfDegree(fit.degree)) + ", " + wordsOf(fit.features);
}

SeriesStyle styleOf(const VectorFit& fit) {
    constexpr int kCubicColour = 5;  // colour that no model has
    SeriesStyle style = styleOf(fit.degree == 1 ? ModelKind::kLinear : ModelKind::kQuadratic, fit.features);
    if (fit.degree == kMaxDegree) style.colour = kCubicColour;
    return style;
}

Series decaySeries(const EigenvalueDecay& decay, int colour) {
    Series series{decay.name, {colour, false, true, false}};
    for (std::size_t i = 0; i < decay.shares.size() && decay.shares[i] >= 1e-7; ++i) {
        series.x.push_back(double(i + 1));
        series.y.push_back(decay.shares[i]);
    }
    series.style.marks = series.x.size() < 24;
    return series;
}

std::string componentsText(const EigenvalueDecay& decay, double share) {
    return (decay.reaches(share) ? "" : "> ") + std::to_string(decay.componentsFor(share));
}

Table decayTable(const std::vector<EigenvalueDecay>& decays, const std::vector<double>& shares) {
    Table table{{"components for"}};
    for (const double share : shares) table.columns.push_back(shortNumber(100 * share) + "%");
    for (const EigenvalueDecay& decay : decays) {
        std::vector<std::string>& row = table.rows.emplace_back(1, decay.name);
        for (const double share : shares) row.push_back(componentsText(decay, share));
    }
    return table;
}

std::vector<const CompareFit*> referenceFits(const Comparison& comparison) {
    std::vector<const CompareFit*> fits;
    for (ModelKind model : comparison.options.models)
        for (FeatureKind features : comparison.options.features)
            if (const CompareFit* fit = findFit(comparison, referenceFit(comparison.options, model, features)))
                fits.push_back(fit);
    return fits;
}

std::vector<Series> sweepSeries(const Comparison& comparison, const Sweep& sweep, const Measure& measure) {
    std::vector<Series> all;
    for (ModelKind model : comparison.options.models)
        for (FeatureKind features : comparison.options.features) {
            Series series{labelOf(model, features), styleOf(model, features)};
            for (std::size_t i = 0; i < sweep.x.size(); ++i) {
                FitOptions options = referenceFit(comparison.options, model, features);
                sweep.vary(options, i);
                const CompareFit* fit = findFit(comparison, options);
                if (!fit) continue;
                series.x.push_back(sweep.x[i]);
                series.y.push_back(measure(*fit));
            }
            if (!series.x.empty()) all.push_back(std::move(series));
        }
    return all;
}

Axis errorAxis(const std::vector<Series>& series) {
    double least = INFINITY, most = 0;
    for (const Series& s : series)
        for (double y : s.y)
            if (std::isfinite(y) && y > 0) {
                least = std::min(least, y);
                most = std::max(most, y);
            }
    return {"relative error", most > 4 * least};
}

Plot variantPlot(const Comparison& comparison, const PlotName& name, const std::vector<Variant>& variants) {
    const CompareOptions& options = comparison.options;
    Plot plot{name.id, name.title, true, {}, {name.y_label, false, true}};
    for (ModelKind model : options.models) plot.x.names.push_back(nameOf(model));
    for (std::size_t v = 0; v < variants.size(); ++v)
        for (FeatureKind features : options.features) {
            const bool hollow = features != FeatureKind::kRelativeBones;
            Series series{wordsOf(features) + ", " + variants[v].name, {int(v), hollow, false, true}};
            for (std::size_t m = 0; m < options.models.size(); ++m) {
                FitOptions fit = referenceFit(options, options.models[m], features);
                variants[v].change(fit);
                const CompareFit* found = findFit(comparison, fit);
                if (!found) continue;
                series.x.push_back(double(m));
                series.y.push_back(variants[v].measure(*found));
            }
            if (!series.x.empty()) plot.series.push_back(std::move(series));
        }
    return plot;
}

Lowest lowestPoint(const std::vector<Series>& series) {
    Lowest lowest;
    for (const Series& s : series)
        for (std::size_t i = 0; i < s.y.size(); ++i)
            if (std::isfinite(s.y[i]) && (!lowest.series || s.y[i] < lowest.y)) lowest = {&s, s.x[i], s.y[i]};
    return lowest;
}

const CompareFit* findFit(const Comparison& comparison, const FitOptions& options) {
    for (const CompareFit& fit : comparison.fits)
        if (sameFit(fit.options, options)) return &fit;
    return nullptr;
}

std::vector<Figure> compareFigures(const Comparison& comparison) {
    std::vector<Figure> figures{modelsFigure(comparison), clustersFigure(comparison), varianceFigure(comparison)};
    if (!comparison.vectors.empty()) figures.push_back(vectorsFigure(comparison));
    if (comparison.sweep) figures.push_back(jointFigure(comparison));
    if (paperConvention(comparison.options, comparison.file_order).order < comparison.file_order)
        figures.push_back(cosineFigure(comparison));
    if (comparison.lobes) figures.push_back(lobesFigure(comparison));
    figures.push_back(framesFigure(comparison));
    if (!comparison.normals.empty()) figures.push_back(normalTableFigure(comparison));
    figures.push_back(conventionsFigure(comparison));
    figures.push_back(eigenvaluesFigure(comparison));
    if (!comparison.lights.empty()) figures.push_back(lightsFigure(comparison));
    figures.push_back(costFigure(comparison));
    return figures;
}

}  // namespace penumbra
