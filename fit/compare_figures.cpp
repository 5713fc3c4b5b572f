#include "fit/compare_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace penumbra {

namespace {

std::string fixed(double value, int digits) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
    return std::isfinite(value) ? buffer : "-";
}

// A colour a model, dashed for the papers' features.
SeriesStyle styleOf(ModelKind model, FeatureKind features) {
    const auto at = std::find(kModelKinds.begin(), kModelKinds.end(), model) - kModelKinds.begin();
    return {int(at) % kPlotColours, features == FeatureKind::kJointAngles};
}

// One series a model and features; `vary` says which fit stands at x.
struct Sweep {
    std::vector<double> x;
    std::function<void(FitOptions&, std::size_t)> vary;
    std::function<double(const CompareFit&)> measure;
};

std::vector<Series> seriesOf(const Comparison& comparison, const Sweep& sweep) {
    std::vector<Series> all;
    for (ModelKind model : comparison.options.models)
        for (FeatureKind features : comparison.options.features) {
            Series series{labelOf(model, features), styleOf(model, features), {}, {}};
            for (std::size_t i = 0; i < sweep.x.size(); ++i) {
                FitOptions options = referenceFit(comparison.options, model, features);
                sweep.vary(options, i);
                const CompareFit* fit = findFit(comparison, options);
                if (!fit) continue;
                series.x.push_back(sweep.x[i]);
                series.y.push_back(sweep.measure(*fit));
            }
            if (!series.x.empty()) all.push_back(std::move(series));
        }
    return all;
}

struct Best {
    std::string name;
    double x = 0, y = INFINITY;
};

Best lowest(const std::vector<Series>& all) {
    Best best;
    for (const Series& series : all)
        for (std::size_t i = 0; i < series.x.size(); ++i)
            if (series.y[i] < best.y) best = {series.name, series.x[i], series.y[i]};
    return best;
}

double heldOutError(const CompareFit& fit) { return fit.report.held_out.relative_error; }
double trainError(const CompareFit& fit) { return fit.report.train.relative_error; }

Table sweepTable(const std::string& first, const std::vector<Series>& held_out, const std::vector<Series>& train) {
    Table table{{"model", first, "held out", "train"}, {}};
    for (std::size_t s = 0; s < held_out.size(); ++s)
        for (std::size_t i = 0; i < held_out[s].x.size(); ++i)
            table.rows.push_back(
                {held_out[s].name, shortNumber(held_out[s].x[i]), fixed(held_out[s].y[i], 4), fixed(train[s].y[i], 4)});
    return table;
}

}  // namespace

const CompareFit* findFit(const Comparison& comparison, const FitOptions& options) {
    for (const CompareFit& fit : comparison.fits)
        if (sameFit(fit.options, options)) return &fit;
    return nullptr;
}

Figure clustersFigure(const Comparison& comparison) {
    const CompareOptions& options = comparison.options;
    Sweep sweep{{options.clusters.begin(), options.clusters.end()},
                [&](FitOptions& fit, std::size_t i) { fit.clusters = options.clusters[i]; },
                heldOutError};
    Figure figure{"clusters", "Error against the number of clusters", "paper 000, figure 4", "", "", {}, {}};
    const Axis x{"clusters", true, false, sweep.x, {}}, y{"relative error", false, false, {}, {}};
    const std::vector<Series> held_out = seriesOf(comparison, sweep);
    sweep.measure = trainError;
    const std::vector<Series> train = seriesOf(comparison, sweep);
    figure.plots.push_back({"plot-clusters-held-out", "Held-out clips", false, x, y, held_out, 1, "static bake"});
    figure.plots.push_back({"plot-clusters-train", "Training clips", false, x, y, train, 1, "static bake"});
    const Best best = lowest(held_out);
    figure.finding =
        "Lowest held-out error: " + fixed(best.y, 3) + ", " + best.name + " with " + shortNumber(best.x) + " clusters.";
    figure.method = "Output variance " + shortNumber(options.referenceVariance()) + ", convention " +
                    options.referenceConvention().name() + ".";
    figure.table = sweepTable("clusters", held_out, train);
    return figure;
}

std::vector<Figure> compareFigures(const Comparison& comparison) { return {clustersFigure(comparison)}; }

}  // namespace penumbra
