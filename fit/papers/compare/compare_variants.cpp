// Figures of fits that differ in kind: model and features, convention, target, frame.
#include <algorithm>
#include <cmath>

#include "fit/papers/compare/compare_series.h"
#include "fit/papers/compare/paper_forms.h"

namespace penumbra {

namespace {

constexpr const char* kAmbientLabel = "mean |error of E|, E in 0..1";

void asReference(FitOptions&) {}

// Changes a fit to those of figures 8 and 9 of Nowrouzezahrai 2009.
std::function<void(FitOptions&)> asPaper(const Comparison& comparison, const NumberForm& form) {
    return [convention = paperConvention(comparison.options, comparison.file_order), &form](FitOptions& fit) {
        fit.convention = convention;
        fit.form = &form;
    };
}

// Compares all bars of the second variant with those of the first, by the geometric mean and the range of their ratios:
// "12.3% higher on average (from 8.0% lower to 15.1% higher)". Series 0..n-1 are the first variant's, one for each of
// the features, and n..2n-1 the second's.
std::string comparedBars(const Plot& plot) {
    double logs = 0, count = 0, low = INFINITY, high = 0;
    const std::size_t half = plot.series.size() / 2;
    for (std::size_t s = 0; s < half; ++s)
        for (std::size_t i = 0; i < plot.series[s].y.size(); ++i) {
            const double value = plot.series[s + half].y[i] / plot.series[s].y[i];
            if (!std::isfinite(value) || value <= 0) continue;
            logs += std::log(value);
            count += 1;
            low = std::min(low, value);
            high = std::max(high, value);
        }
    const auto words = [](double r) {
        return std::abs(r - 1) < 5e-4 ? "the same" : percent(std::abs(r - 1)) + (r < 1 ? " lower" : " higher");
    };
    std::string text = words(count > 0 ? std::exp(logs / count) : NAN);
    if (high > low * 1.0005) text += " on average (from " + words(low) + " to " + words(high) + ")";
    return text;
}

// Returns a table with a row for each bar and a column for each plot.
Table barTable(const std::vector<Plot>& plots) {
    Table table{{"model", "fit"}};
    for (const Plot& plot : plots) table.columns.push_back(plot.title);
    for (std::size_t m = 0; m < plots.front().x.names.size(); ++m)
        for (std::size_t s = 0; s < plots.front().series.size(); ++s) {
            std::vector<std::string> row{plots.front().x.names[m], plots.front().series[s].name};
            for (const Plot& plot : plots)
                row.push_back(m < plot.series[s].y.size() ? shortNumber(plot.series[s].y[m]) : "-");
            table.rows.push_back(row);
        }
    return table;
}

std::string fitName(const CompareFit& fit) { return labelOf(fit.options); }

// Returns every model at the reference, then the composed one if there is one.
std::vector<const CompareFit*> rowsOf(const Comparison& comparison) {
    std::vector<const CompareFit*> rows = referenceFits(comparison);
    if (comparison.options.fields.empty()) return rows;
    const CompareFit* composed = findFit(comparison, composedFit(comparison.options, comparison.file_order));
    if (composed) rows.push_back(composed);
    return rows;
}

// The papers have linear, quadratic and neural models of angles.
bool isOfPapers(const CompareFit* fit) {
    return fit->options.features != FeatureKind::kRelativeBones && fit->options.model != ModelKind::kAdditive;
}

// Says which model loses most, and which least, from training clips to novel poses.
std::string gapFinding(const Comparison& comparison) {
    const std::vector<const CompareFit*> fits = referenceFits(comparison);
    if (fits.empty()) return "";
    const auto gap = [](const CompareFit* fit) { return heldOutError(*fit) - trainError(*fit); };
    const CompareFit *most = std::ranges::max(fits, {}, gap), *least = std::ranges::min(fits, {}, gap);
    const auto words = [](const CompareFit& fit) {
        return fitName(fit) + " (" + fixedNumber(trainError(fit), 3) + " to " + fixedNumber(heldOutError(fit), 3) + ")";
    };
    std::string text = "The step from training clips to novel poses is largest for " + words(*most);
    if (least != most) text += ", smallest for " + words(*least);
    return text + ".";
}

// Lists the errors of each held-out clip under each model at the reference.
Table clipTable(const Comparison& comparison) {
    Table table{{"model", "held-out clip", "relative error", "rms V", "ambient error"}};
    for (const CompareFit* fit : rowsOf(comparison)) {
        const auto add = [&](const std::string& clip, const ErrorFigures& errors) {
            table.rows.push_back({fitName(*fit), clip, fixedNumber(errors.relative_error, 4),
                                  fixedNumber(errors.rms_v, 4), fixedNumber(errors.ambient_error, 4)});
        };
        for (const ClipError& clip : fit->clip_errors)
            if (clip.held_out) add(clip.clip, {clip.relative_error, clip.rms_v, clip.ambient_error});
        add("all held out", fit->report.held_out);
        add("all training", fit->report.train);
    }
    return table;
}

}  // namespace

Table summaryTable(const Comparison& comparison) {
    Table table{{"model", "held out, relative", "train, relative", "held out, ambient", "inputs a cluster",
                 "components a cluster", "bytes a vertex", "fit, s", "evaluate, ms"}};
    for (const CompareFit* fit : rowsOf(comparison))
        table.rows.push_back({fitName(*fit), fixedNumber(heldOutError(*fit), 4), fixedNumber(trainError(*fit), 4),
                              fixedNumber(heldOutAmbient(*fit), 4), fixedNumber(fit->inputs, 1),
                              fixedNumber(fit->components, 1), fixedNumber(fit->bytes_per_vertex, 0),
                              fixedNumber(fit->fit_seconds, 2), fixedNumber(fit->evaluate_milliseconds, 2)});
    return table;
}

std::string modelsFinding(const Comparison& comparison) {
    std::vector<const CompareFit*> fits = referenceFits(comparison);
    if (fits.empty()) return "";
    const auto error = [](const CompareFit* fit) { return heldOutError(*fit); };
    const CompareFit* best = std::ranges::min(fits, {}, error);
    std::erase_if(fits, [](const CompareFit* fit) { return !isOfPapers(fit); });
    const CompareFit* paper = fits.empty() ? nullptr : std::ranges::min(fits, {}, error);
    std::string text = "On novel poses " + fitName(*best) + " is best, with a relative error of " +
                       fixedNumber(heldOutError(*best), 3);
    if (paper && paper != best)
        text += ", " + fixedNumber(heldOutError(*best) / heldOutError(*paper), 2) +
                " times that of the papers' best (" + fitName(*paper) + ", " + fixedNumber(heldOutError(*paper), 3) +
                ")";
    text += ".";
    if (comparison.options.fields.empty()) return text;
    const CompareFit* composed = findFit(comparison, composedFit(comparison.options, comparison.file_order));
    const CompareFit* additive = findFit(comparison, mirroredAdditiveFit(comparison.options, comparison.file_order));
    if (composed && additive)
        text += " In convention " + composed->options.convention.name() + " the composed model has " +
                fixedNumber(heldOutError(*composed), 3) + ", where the additive one has " +
                fixedNumber(heldOutError(*additive), 3) + ".";
    return text;
}

Figure modelsFigure(const Comparison& comparison) {
    Figure figure{"models", "Each model on novel poses", "Nowrouzezahrai 2009, figure 7", gapFinding(comparison)};
    const Measure train_ambient = [](const CompareFit& fit) { return fit.report.train.ambient_error; };
    figure.plots = {variantPlot(comparison, {"plot-models-error", "Relative error", "relative error"},
                                {{"held out", asReference, heldOutError}, {"train", asReference, trainError}}),
                    variantPlot(comparison, {"plot-models-ambient", "Ambient error", kAmbientLabel},
                                {{"held out", asReference, heldOutAmbient}, {"train", asReference, train_ambient}})};
    figure.plots[0].rule = 1;
    figure.plots[0].rule_label = "static bake";
    figure.method = std::to_string(comparison.options.referenceClusters()) + " clusters, output variance " +
                    shortNumber(comparison.options.referenceVariance()) + ", convention " +
                    comparison.options.referenceConvention().name() +
                    ". E is ambient visibility: the cosine-weighted open share of the hemisphere.";
    figure.table = clipTable(comparison);
    return figure;
}

Figure conventionsFigure(const Comparison& comparison) {
    std::vector<Variant> errors, ambient;
    for (const Convention& convention : comparison.options.conventions) {
        const auto change = [convention](FitOptions& fit) { fit.convention = convention; };
        errors.push_back({convention.name(), change, heldOutError});
        ambient.push_back({convention.name(), change, heldOutAmbient});
    }
    Figure figure{"conventions", "Conventions",
                  "Ours: how the half sphere below the horizon is filled, and the SH order"};
    figure.plots = {
        variantPlot(comparison, {"plot-conventions-error", "Held-out relative error", "relative error"}, errors),
        variantPlot(comparison, {"plot-conventions-ambient", "Held-out ambient error", kAmbientLabel}, ambient)};
    if (const Lowest best = lowestPoint(figure.plots[1].series); best.series)
        figure.finding = "The lowest ambient error on held-out clips is " + fixedNumber(best.y, 4) + ": " +
                         figure.plots[1].x.names[std::size_t(best.x)] + ", " + best.series->name + ".";
    figure.method =
        "A: 1 below the horizon (Nowrouzezahrai 2009, equation 1); B: 0; D: mirrored, which keeps the even numbers "
        "only. Relative errors are of each convention's own numbers; ambient errors compare across conventions.";
    figure.table = barTable(figure.plots);
    return figure;
}

Figure cosineFigure(const Comparison& comparison) {
    const Convention paper = paperConvention(comparison.options, comparison.file_order);
    const auto bars = [&](const PlotName& name, const Measure& of_plain, const Measure& of_weighted) {
        return variantPlot(comparison, name,
                           {{"visibility", asPaper(comparison, kUnclampedForm), of_plain},
                            {"visibility x cosine", asPaper(comparison, kCosineForm), of_weighted}});
    };
    const Measure product = [](const CompareFit& fit) { return fit.cosine_product_error; };
    Figure figure{"cosine", "With and without the cosine", "Nowrouzezahrai 2009, figure 8"};
    figure.plots = {
        bars({"plot-cosine-error", "Held-out relative error", "relative error, of own numbers"}, heldOutError,
             heldOutError),
        bars({"plot-cosine-product", "Held-out relative error of V x cosine",
              "relative error, of cosine-weighted numbers"},
             product, heldOutError),
        bars({"plot-cosine-ambient", "Held-out ambient error", kAmbientLabel}, heldOutAmbient, heldOutAmbient)};
    figure.finding = "With the cosine in the data the held-out relative error is " + comparedBars(figure.plots[0]) +
                     ", the ambient error " + comparedBars(figure.plots[2]) + ". On V x cosine itself the error is " +
                     comparedBars(figure.plots[1]) +
                     " with the cosine in the data than where it is multiplied in at run time.";
    figure.method =
        "Both are fitted and measured in the same way, with " + std::to_string(paper.order * paper.order) +
        " numbers a vertex in local frames (" + paper.name() +
        "). V max(cos, 0) is made exactly from the baked moments: z y_lm is a sum of y_(l-1)m and y_(l+1)m, and the "
        "bake has one order more. The ambient error compares the same quantity: E is the first cosine-weighted number, "
        "and a weighted sum of the plain ones. As in the paper, E is not clamped. In the second plot, what the fit of "
        "visibility predicts is multiplied by C of equation 14, which the bands above the convention's order make "
        "inexact; both are measured against the same baked numbers.";
    figure.table = barTable(figure.plots);
    return figure;
}

Figure framesFigure(const Comparison& comparison) {
    const Convention paper = paperConvention(comparison.options, comparison.file_order);
    const auto bars = [&](const PlotName& name, const Measure& of_both) {
        return variantPlot(comparison, name,
                           {{"local frame", asPaper(comparison, kUnclampedForm), of_both},
                            {"model frame", asPaper(comparison, kModelFrameForm), of_both}});
    };
    Figure figure{"frames", "Local against global frames", "Nowrouzezahrai 2009, figure 9"};
    figure.plots = {bars({"plot-frames-error", "Held-out error, rms V", "rms V"},
                         [](const CompareFit& fit) { return fit.report.held_out.rms_v; }),
                    bars({"plot-frames-bytes", "Bytes a vertex at the same output variance", "bytes a vertex"},
                         [](const CompareFit& fit) { return fit.bytes_per_vertex; })};
    figure.finding = "In the model frame the held-out error is " + comparedBars(figure.plots[0]) +
                     " than in local frames, the size " + comparedBars(figure.plots[1]) + ".";
    figure.method = "The same functions in both frames, convention " + paper.name() +
                    ", so that rms V, which no rotation changes, compares them; relative errors would not, as numbers "
                    "in the model frame also vary because the surface turns. As in the paper, E is not clamped.";
    figure.table = barTable(figure.plots);
    return figure;
}

}  // namespace penumbra
