// Figures of fits that differ in kind: model and features, convention, target, frame.
#include <algorithm>
#include <cmath>

#include "fit/compare/compare_series.h"

namespace penumbra {

namespace {

void asReference(FitOptions&) {}

// Changes a fit to those of figures 8 and 9 of Nowrouzezahrai 2009.
void asPaper(FitOptions& fit, const Convention& convention) {
    fit.convention = convention;
    fit.clamp = false;
}

// The ratios of all bars of the second variant to those of the first: their geometric mean and range.
struct Ratio {
    double mean = NAN, low = INFINITY, high = 0;
};

// Computes these ratios. Series 0..n-1 are the first variant's, one for each of the features, and n..2n-1 the second's.
Ratio ratioOf(const Plot& plot) {
    Ratio ratio;
    double logs = 0, count = 0;
    const std::size_t half = plot.series.size() / 2;
    for (std::size_t s = 0; s < half; ++s)
        for (std::size_t i = 0; i < plot.series[s].y.size(); ++i) {
            const double value = plot.series[s + half].y[i] / plot.series[s].y[i];
            if (!std::isfinite(value) || value <= 0) continue;
            logs += std::log(value);
            count += 1;
            ratio.low = std::min(ratio.low, value);
            ratio.high = std::max(ratio.high, value);
        }
    if (count > 0) ratio.mean = std::exp(logs / count);
    return ratio;
}

// Returns a text such as "12.3% higher on average (from 8.0% lower to 15.1% higher)".
std::string comparedWith(const Ratio& ratio) {
    const auto words = [](double r) {
        return std::abs(r - 1) < 5e-4 ? "the same" : percent(std::abs(r - 1)) + (r < 1 ? " lower" : " higher");
    };
    std::string text = words(ratio.mean);
    if (ratio.high > ratio.low * 1.0005)
        text += " on average (from " + words(ratio.low) + " to " + words(ratio.high) + ")";
    return text;
}

Plot named(Plot plot, const std::string& id, const std::string& title, const std::string& y_label) {
    plot.id = id;
    plot.title = title;
    plot.y.label = y_label;
    return plot;
}

// Returns a table with a row for each bar and a column for each plot.
Table barTable(const std::vector<Plot>& plots) {
    Table table{{"model", "fit"}, {}};
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

// Returns the model with the least held-out error. The papers have linear, quadratic and neural models of angles.
const CompareFit* bestOf(const Comparison& comparison, bool papers_only) {
    const CompareFit* best = nullptr;
    for (ModelKind model : comparison.options.models)
        for (FeatureKind features : comparison.options.features) {
            if (papers_only && (features == FeatureKind::kRelativeBones || model == ModelKind::kAdditive)) continue;
            const CompareFit* fit = findFit(comparison, referenceFit(comparison.options, model, features));
            if (fit && (!best || heldOutError(*fit) < heldOutError(*best))) best = fit;
        }
    return best;
}

std::string fitName(const CompareFit& fit) { return labelOf(fit.options); }

// Returns every model at the reference, then the composed one if there is one.
std::vector<const CompareFit*> rowsOf(const Comparison& comparison) {
    const CompareOptions& options = comparison.options;
    std::vector<const CompareFit*> rows;
    const auto add = [&](const FitOptions& options_of_row) {
        if (const CompareFit* fit = findFit(comparison, options_of_row)) rows.push_back(fit);
    };
    for (ModelKind model : options.models)
        for (FeatureKind features : options.features) add(referenceFit(options, model, features));
    if (!options.fields.empty()) add(composedFit(options, comparison.file_order));
    return rows;
}

// Says which model loses most, and which least, from training clips to novel poses.
std::string gapFinding(const Comparison& comparison) {
    const CompareFit *most = nullptr, *least = nullptr;
    const auto gap = [](const CompareFit& fit) { return heldOutError(fit) - trainError(fit); };
    for (ModelKind model : comparison.options.models)
        for (FeatureKind features : comparison.options.features) {
            const CompareFit* fit = findFit(comparison, referenceFit(comparison.options, model, features));
            if (fit && (!most || gap(*fit) > gap(*most))) most = fit;
            if (fit && (!least || gap(*fit) < gap(*least))) least = fit;
        }
    if (!most) return "";
    const auto words = [](const CompareFit& fit) {
        return fitName(fit) + " (" + fixedNumber(trainError(fit), 3) + " to " + fixedNumber(heldOutError(fit), 3) + ")";
    };
    std::string text = "The step from training clips to novel poses is largest for " + words(*most);
    if (least != most) text += ", smallest for " + words(*least);
    return text + ".";
}

// Lists the errors of each held-out clip under each model at the reference.
Table clipTable(const Comparison& comparison) {
    Table table{{"model", "held-out clip", "relative error", "rms V", "ambient error"}, {}};
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
                 "components a cluster", "bytes a vertex", "fit, s", "evaluate, ms"},
                {}};
    for (const CompareFit* fit : rowsOf(comparison))
        table.rows.push_back({fitName(*fit), fixedNumber(heldOutError(*fit), 4), fixedNumber(trainError(*fit), 4),
                              fixedNumber(heldOutAmbient(*fit), 4), fixedNumber(fit->inputs, 1),
                              fixedNumber(fit->components, 1), fixedNumber(fit->bytes_per_vertex, 0),
                              fixedNumber(fit->fit_seconds, 2), fixedNumber(fit->evaluate_milliseconds, 2)});
    return table;
}

std::string modelsFinding(const Comparison& comparison) {
    const CompareFit *best = bestOf(comparison, false), *paper = bestOf(comparison, true);
    if (!best) return "";
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
    Figure figure{
        "models", "Each model on novel poses", "Nowrouzezahrai 2009, figure 7", gapFinding(comparison), "", {}, {}};
    const Plot errors =
        variantPlot(comparison, {{"held out", asReference, heldOutError}, {"train", asReference, trainError}});
    const Plot ambient = variantPlot(
        comparison, {{"held out", asReference, heldOutAmbient},
                     {"train", asReference, [](const CompareFit& fit) { return fit.report.train.ambient_error; }}});
    figure.plots = {named(errors, "plot-models-error", "Relative error", "relative error"),
                    named(ambient, "plot-models-ambient", "Ambient error", "mean |error of E|, E in 0..1")};
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
    Figure figure{"conventions",
                  "Conventions",
                  "Ours: how the half sphere below the horizon is filled, and the SH order",
                  "",
                  "",
                  {},
                  {}};
    figure.plots = {
        named(variantPlot(comparison, errors), "plot-conventions-error", "Held-out relative error", "relative error"),
        named(variantPlot(comparison, ambient), "plot-conventions-ambient", "Held-out ambient error",
              "mean |error of E|, E in 0..1")};
    if (const Lowest best = lowestPoint(figure.plots[1].series); best.series)
        figure.finding = "The lowest ambient error on held-out clips is " + fixedNumber(best.y, 4) + ": " +
                         figure.plots[1].x.names[std::size_t(best.x)] + ", " + best.series->name + ".";
    figure.method =
        "A: 1 below the horizon (Nowrouzezahrai 2009, equation 1); B: 0; D: mirrored, which keeps the even numbers "
        "only. "
        "Relative "
        "errors are of each convention's own numbers; ambient errors compare across conventions.";
    figure.table = barTable(figure.plots);
    return figure;
}

Figure cosineFigure(const Comparison& comparison) {
    const Convention paper = paperConvention(comparison.options, comparison.file_order);
    const auto plain = [paper](FitOptions& fit) { asPaper(fit, paper); };
    const auto weighted = [paper](FitOptions& fit) {
        asPaper(fit, paper);
        fit.target = Target::kCosineWeighted;
    };
    const Measure product = [](const CompareFit& fit) { return fit.cosine_product_error; };
    const Plot errors =
        variantPlot(comparison, {{"visibility", plain, heldOutError}, {"visibility x cosine", weighted, heldOutError}});
    const Plot again =
        variantPlot(comparison, {{"visibility", plain, product}, {"visibility x cosine", weighted, heldOutError}});
    const Plot ambient = variantPlot(
        comparison, {{"visibility", plain, heldOutAmbient}, {"visibility x cosine", weighted, heldOutAmbient}});
    Figure figure{"cosine", "With and without the cosine", "Nowrouzezahrai 2009, figure 8", "", "", {}, {}};
    figure.plots = {named(errors, "plot-cosine-error", "Held-out relative error", "relative error, of own numbers"),
                    named(again, "plot-cosine-product", "Held-out relative error of V x cosine",
                          "relative error, of cosine-weighted numbers"),
                    named(ambient, "plot-cosine-ambient", "Held-out ambient error", "mean |error of E|, E in 0..1")};
    figure.finding = "With the cosine in the data the held-out relative error is " + comparedWith(ratioOf(errors)) +
                     ", the ambient error " + comparedWith(ratioOf(ambient)) + ". On V x cosine itself the error is " +
                     comparedWith(ratioOf(again)) +
                     " with the cosine in the data than where it is multiplied in at run time.";
    figure.method =
        "Both are fitted and measured in the same way, with " + std::to_string(paper.order * paper.order) +
        " numbers a vertex in local frames (" + paper.name() +
        "). V max(cos, 0) is made exactly from the baked moments: z y_lm is a sum of y_(l-1)m and "
        "y_(l+1)m, and the bake has one order more. The ambient error compares the same quantity: E is "
        "the first cosine-weighted number, and a weighted sum of the plain ones. As in the paper, E is not clamped. "
        "In the second plot, what the fit of visibility predicts is multiplied by C of equation 14, which the bands "
        "above "
        "the convention's order make inexact; both are measured against the same baked numbers.";
    figure.table = barTable(figure.plots);
    return figure;
}

Figure framesFigure(const Comparison& comparison) {
    const Convention paper = paperConvention(comparison.options, comparison.file_order);
    const auto local = [paper](FitOptions& fit) { asPaper(fit, paper); };
    const auto global = [paper](FitOptions& fit) {
        asPaper(fit, paper);
        fit.frame = Frame::kGlobal;
    };
    const Measure rms = [](const CompareFit& fit) { return fit.report.held_out.rms_v; };
    const Measure bytes = [](const CompareFit& fit) { return fit.bytes_per_vertex; };
    const Plot errors = variantPlot(comparison, {{"local frame", local, rms}, {"model frame", global, rms}});
    const Plot sizes = variantPlot(comparison, {{"local frame", local, bytes}, {"model frame", global, bytes}});
    Figure figure{"frames", "Local against global frames", "Nowrouzezahrai 2009, figure 9", "", "", {}, {}};
    figure.plots = {named(errors, "plot-frames-error", "Held-out error, rms V", "rms V"),
                    named(sizes, "plot-frames-bytes", "Bytes a vertex at the same output variance", "bytes a vertex")};
    figure.finding = "In the model frame the held-out error is " + comparedWith(ratioOf(errors)) +
                     " than in local frames, the size " + comparedWith(ratioOf(sizes)) + ".";
    figure.method =
        "The same functions in both frames, convention " + paper.name() +
        ", so that rms V, which no rotation changes, compares them; relative errors would not, as numbers in the model "
        "frame also vary because the surface turns. As in the paper, E is not clamped.";
    figure.table = barTable(figure.plots);
    return figure;
}

}  // namespace penumbra
