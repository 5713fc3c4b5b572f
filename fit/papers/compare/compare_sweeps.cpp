// Figures of fits that differ in a number (clusters, output variance), and the figure of what each fit costs.
#include <algorithm>
#include <cmath>

#include "fit/papers/compare/compare_series.h"

namespace penumbra {

namespace {

Table sweepTable(const std::string& varied, const std::vector<Series>& held_out, const std::vector<Series>& train,
                 const std::vector<Series>& bytes) {
    Table table{{"model", varied, "held out", "train", "bytes a vertex"}};
    for (std::size_t s = 0; s < held_out.size(); ++s)
        for (std::size_t i = 0; i < held_out[s].x.size(); ++i)
            table.rows.push_back({held_out[s].name, shortNumber(held_out[s].x[i]), fixedNumber(held_out[s].y[i], 4),
                                  fixedNumber(train[s].y[i], 4), fixedNumber(bytes[s].y[i], 0)});
    return table;
}

double bytesOf(const CompareFit& fit) { return fit.bytes_per_vertex; }

}  // namespace

Figure clustersFigure(const Comparison& comparison) {
    const CompareOptions& options = comparison.options;
    const Sweep sweep{{options.clusters.begin(), options.clusters.end()},
                      [&](FitOptions& fit, std::size_t i) { fit.clusters = options.clusters[i]; }};
    const std::vector<Series> held_out = sweepSeries(comparison, sweep, heldOutError),
                              train = sweepSeries(comparison, sweep, trainError),
                              bytes = sweepSeries(comparison, sweep, bytesOf);
    const Axis x{"clusters", true, false, sweep.x};
    Figure figure{"clusters", "Error against the number of clusters", "Nowrouzezahrai 2009, figure 4"};
    figure.plots = {
        {"plot-clusters-held-out", "Held-out clips", false, x, errorAxis(held_out), held_out, 1, "static bake"},
        {"plot-clusters-train", "Training clips", false, x, errorAxis(train), train, 1, "static bake"}};
    if (const Lowest best = lowestPoint(held_out); best.series) {
        figure.finding = "The lowest held-out error, " + fixedNumber(best.y, 3) + ", is that of " + best.series->name +
                         " with " + shortNumber(best.x) + " clusters";
        const std::vector<double>& y = best.series->y;
        if (y.size() > 1)
            figure.finding += "; from " + shortNumber(sweep.x.front()) + " to " + shortNumber(sweep.x.back()) +
                              " clusters it goes from " + fixedNumber(y.front(), 3) + " to " + fixedNumber(y.back(), 3);
        figure.finding += ".";
    }
    figure.method = "Output variance " + shortNumber(options.referenceVariance()) + ", convention " +
                    options.referenceConvention().name() +
                    ". Clusters are those of mean-shift on the skinning weights (of a mesh without skeleton its "
                    "near-rigid parts), merged or split to the asked number.";
    figure.table = sweepTable("clusters", held_out, train, bytes);
    return figure;
}

Figure varianceFigure(const Comparison& comparison) {
    const CompareOptions& options = comparison.options;
    const Sweep sweep{options.output_variances,
                      [&](FitOptions& fit, std::size_t i) { fit.output_variance = options.output_variances[i]; }};
    const std::vector<Series> held_out = sweepSeries(comparison, sweep, heldOutError),
                              bytes = sweepSeries(comparison, sweep, bytesOf);
    std::vector<Series> train = sweepSeries(comparison, sweep, trainError);
    const std::vector<Series> floors =
        sweepSeries(comparison, sweep, [](const CompareFit& fit) { return fit.report.output_floor; });
    const Axis x{"output variance kept", false, false, sweep.x};
    Figure figure{"output-variance", "Error against output variance", "Nowrouzezahrai 2009, figure 5"};
    figure.table = sweepTable("output variance", held_out, train, bytes);
    // The floor is the same for every model on every feature.
    train.push_back({"output PCA alone", {6, false}, floors.front().x, floors.front().y});
    figure.plots = {
        {"plot-variance-train", "Training clips", false, x, errorAxis(train), train, 1, "static bake"},
        {"plot-variance-held-out", "Held-out clips", false, x, errorAxis(held_out), held_out, 1, "static bake"}};
    if (const Lowest best = lowestPoint(held_out); best.series) {
        const std::vector<double>& y = best.series->y;
        figure.finding =
            "From " + shortNumber(sweep.x.front()) + " to " + shortNumber(sweep.x.back()) +
            " of the variance the held-out error of " + best.series->name + " goes from " + fixedNumber(y.front(), 3) +
            " to " + fixedNumber(y.back(), 3) + ", while what PCA alone loses on training frames goes from " +
            fixedNumber(floors.front().y.front(), 3) + " to " + fixedNumber(floors.front().y.back(), 3) + ".";
    }
    figure.method = std::to_string(options.referenceClusters()) + " clusters, convention " +
                    options.referenceConvention().name() +
                    ". The error of the output PCA alone is measured on training frames.";
    return figure;
}

namespace {

// Plots the held-out error against a cost, over the numbers of clusters.
Plot costPlot(const Comparison& comparison, const std::string& id, const std::string& title, const Axis& x,
              const Measure& cost) {
    const CompareOptions& options = comparison.options;
    const Sweep sweep{{options.clusters.begin(), options.clusters.end()},
                      [&](FitOptions& fit, std::size_t i) { fit.clusters = options.clusters[i]; }};
    const std::vector<Series> errors = sweepSeries(comparison, sweep, heldOutError);
    Plot plot{id, title, false, x, errorAxis(errors), errors, 1, "static bake"};
    const std::vector<Series> costs = sweepSeries(comparison, sweep, cost);
    for (std::size_t s = 0; s < costs.size(); ++s) plot.series[s].x = costs[s].y;
    return plot;
}

bool isPlain(const CompareFit& fit) { return fit.options.form == &kVisibilityForm && fit.options.prior; }

// Names the best and the smallest of all plain fits in the reference's convention.
std::string costFinding(const Comparison& comparison) {
    const CompareFit *best = nullptr, *smallest = nullptr;
    for (const CompareFit& fit : comparison.fits) {
        if (!isPlain(fit) || fit.options.convention != comparison.options.referenceConvention()) continue;
        if (!best || heldOutError(fit) < heldOutError(*best)) best = &fit;
        if (!smallest || fit.bytes_per_vertex < smallest->bytes_per_vertex) smallest = &fit;
    }
    if (!best) return "";
    const auto words = [](const CompareFit& fit) {
        return fixedNumber(fit.bytes_per_vertex, 0) + " bytes a vertex for a held-out error of " +
               fixedNumber(heldOutError(fit), 3) + " (" + describe(fit.options) + ")";
    };
    return "The most accurate fit takes " + words(*best) + ", the smallest " + words(*smallest) + ".";
}

}  // namespace

Figure costFigure(const Comparison& comparison) {
    Figure figure{"cost", "What a model costs", "Nowrouzezahrai 2009, table 1", costFinding(comparison)};
    const auto axis = [](const char* label) { return Axis{label, true}; };
    figure.plots = {costPlot(comparison, "plot-cost-bytes", "Size", axis("bytes a vertex"), bytesOf),
                    costPlot(comparison, "plot-cost-fit", "Time to fit", axis("seconds"),
                             [](const CompareFit& fit) { return fit.fit_seconds; }),
                    costPlot(comparison, "plot-cost-evaluate", "Time to evaluate", axis("milliseconds a frame"),
                             [](const CompareFit& fit) { return fit.evaluate_milliseconds; })};
    figure.method =
        "One point for each number of clusters. Size: the 32-bit numbers of all clusters, before any quantisation. "
        "Time to fit: clusters, tangents, reading of the numbers, cross-validation and fit, on the threads of this "
        "run. Time to evaluate: Predictor::predict() of the fit library, one thread, median of 9 frames; "
        "penumbra-player bench times the run-time evaluator, which is another implementation.";
    figure.table.columns = {"model", "clusters", "output variance", "convention", "held out", "inputs a cluster"};
    for (const char* name : {"components a cluster", "bytes a vertex", "fit, s", "evaluate, ms"})
        figure.table.columns.push_back(name);
    for (const CompareFit& fit : comparison.fits)
        if (isPlain(fit))
            figure.table.rows.push_back({labelOf(fit.options.model, fit.options.features), std::to_string(fit.clusters),
                                         shortNumber(fit.options.output_variance), fit.options.convention.name(),
                                         fixedNumber(heldOutError(fit), 4), fixedNumber(fit.inputs, 1),
                                         fixedNumber(fit.components, 1), fixedNumber(fit.bytes_per_vertex, 0),
                                         fixedNumber(fit.fit_seconds, 2), fixedNumber(fit.evaluate_milliseconds, 2)});
    return figure;
}

}  // namespace penumbra
