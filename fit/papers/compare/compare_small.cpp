// Figures of what Nowrouzezahrai 2009 tells beside its models (feature vectors and priors, tables of normals, lights
// and lobes), and of Nowrouzezahrai 2008's lobes of visibility.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "fit/papers/compare/compare_series.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

const VectorFit* findVector(const Comparison& comparison, FeatureKind features, int degree, bool prior) {
    for (const VectorFit& fit : comparison.vectors)
        if (fit.features == features && fit.degree == degree && fit.prior == prior) return &fit;
    return nullptr;
}

// One series for each of the features with and without the prior.
Plot vectorPlot(const Comparison& comparison, const std::string& id, const std::string& title,
                ErrorFigures VectorFit::*errors) {
    std::vector<Series> all;
    for (const bool prior : {true, false})
        for (const FeatureKind features : comparison.options.features) {
            Series series{wordsOf(features) + (prior ? ", prior" : ", no prior"),
                          {prior ? 0 : 1, features != FeatureKind::kRelativeBones}};
            for (int degree = 1; degree <= kMaxDegree; ++degree) {
                const VectorFit* fit = findVector(comparison, features, degree, prior);
                if (!fit) continue;
                series.x.push_back(degree);
                series.y.push_back((fit->*errors).relative_error);
            }
            all.push_back(std::move(series));
        }
    const Axis x{"degree of the feature vector", false, false, {1, 2, 3}};
    return {id, title, false, x, errorAxis(all), all, 1, "static bake"};
}

// One row of the figure's table.
struct PriorRow {
    std::string name;
    FeatureKind features = FeatureKind::kRelativeBones;
    std::optional<ModelKind> model;  // none: a feature vector
    bool prior = true;
    double held_out = 0, train = 0, units = 0, bytes = 0;

    std::string text() const { return name + (prior ? "" : ", no prior"); }
};

// Returns the feature vectors, and the models of the grid that have fits without prior.
std::vector<PriorRow> priorRows(const Comparison& comparison) {
    std::vector<PriorRow> rows;
    for (const VectorFit& fit : comparison.vectors)
        rows.push_back({labelOf(fit),
                        fit.features,
                        {},
                        fit.prior,
                        fit.held_out.relative_error,
                        fit.train.relative_error,
                        fit.units,
                        fit.bytes_per_vertex});
    for (const ModelKind model : comparison.options.models)
        for (const FeatureKind features : comparison.options.features)
            for (const bool prior : {true, false}) {
                FitOptions options = referenceFit(comparison.options, model, features);
                options.prior = prior;
                const CompareFit* fit = compressesWithoutPrior(model) ? findFit(comparison, options) : nullptr;
                if (fit)
                    rows.push_back({labelOf(model, features), features, model, prior, heldOutError(*fit),
                                    trainError(*fit), fit->units, fit->bytes_per_vertex});
            }
    return rows;
}

// Bars of the training errors of the models that have fits without prior.
Plot compressionPlot(const Comparison& comparison) {
    Plot plot{"plot-vectors-models", "Training clips, other models", true, {""}, {"relative error", false, true}};
    for (const ModelKind model : comparison.options.models)
        if (compressesWithoutPrior(model)) plot.x.names.push_back(nameOf(model));
    for (const PriorRow& row : priorRows(comparison)) {
        if (!row.model) continue;
        const auto place = std::ranges::find(plot.x.names, nameOf(*row.model)) - plot.x.names.begin();
        const std::string name = wordsOf(row.features) + (row.prior ? ", prior" : ", no prior");
        auto series = std::ranges::find(plot.series, name, &Series::name);
        if (series == plot.series.end()) {
            const bool hollow = row.features != FeatureKind::kRelativeBones;
            plot.series.push_back({name, {row.prior ? 0 : 1, hollow, false, true}});
            series = plot.series.end() - 1;
        }
        series->x.push_back(double(place));
        series->y.push_back(row.train);
    }
    return plot;
}

std::string errorText(const FrameSpread& errors) {
    if (!std::isfinite(errors.mean)) return "-";
    return fixedNumber(errors.mean, 3) + " +- " + fixedNumber(errors.deviation, 3);
}

}  // namespace

Figure vectorsFigure(const Comparison& comparison) {
    Figure figure{"feature-vectors", "Higher-order feature vectors, and no prior",
                  "Nowrouzezahrai 2009, figure 7 and section 5.3"};
    figure.plots = {vectorPlot(comparison, "plot-vectors-held-out", "Held-out clips", &VectorFit::held_out),
                    vectorPlot(comparison, "plot-vectors-train", "Training clips (compression)", &VectorFit::train)};
    if (std::ranges::any_of(comparison.options.models, compressesWithoutPrior))
        figure.plots.push_back(compressionPlot(comparison));
    figure.table.columns = {"fit", "prior", "held out", "train", "units a cluster", "bytes a vertex"};
    const std::vector<PriorRow> rows = priorRows(comparison);
    for (const PriorRow& row : rows)
        figure.table.rows.push_back({row.name, row.prior ? "cross-validated" : "none", fixedNumber(row.held_out, 4),
                                     fixedNumber(row.train, 4), fixedNumber(row.units, 1), fixedNumber(row.bytes, 0)});
    const PriorRow &held_out = std::ranges::min(rows, {}, &PriorRow::held_out),
                   &train = std::ranges::min(rows, {}, &PriorRow::train);
    figure.finding = "On novel poses " + held_out.text() + " is best (" + fixedNumber(held_out.held_out, 3) +
                     "). As compression of the training clips " + train.text() + " is best (" +
                     fixedNumber(train.train, 3) + ", and " + fixedNumber(train.held_out, 3) + " on novel poses).";
    figure.method =
        "Linear models of the reduced inputs, of all their products of two, and of three (of the first 21 inputs). "
        "With the prior, alpha comes from blocked cross-validation. Without it the fit is plain least squares, the "
        "shortest where there are more units than frames: the paper's mode for compression. Inputs are clamped to the "
        "range of the training frames, and predictions of feature vectors are not clamped. Neural and additive models "
        "without prior have the most units that cross-validation may choose, and as little prior as can be solved. "
        "Output variance " +
        shortNumber(comparison.options.referenceVariance()) + ", convention " +
        comparison.options.referenceConvention().name() + ".";
    return figure;
}

Figure normalTableFigure(const Comparison& comparison) {
    const Convention paper = paperConvention(comparison.options, comparison.file_order);
    Figure figure{"normal-tables", "Operators for a table of normals", "Nowrouzezahrai 2009, section 5.4"};
    Series diffuse{"Lambertian", {0, false}}, glossy{"Phong, exponent 10", {1, false}};
    figure.table.columns = {"normals", "mean angle, degrees", "Lambertian", "Phong, exponent 10", "operators, MB"};
    for (const NormalTable& table : comparison.normals) {
        for (Series* series : {&diffuse, &glossy}) series->x.push_back(table.normals);
        diffuse.y.push_back(table.diffuse);
        glossy.y.push_back(table.glossy);
        figure.table.rows.push_back(
            {std::to_string(table.normals), fixedNumber(table.angle * 180 / std::numbers::pi, 2),
             fixedNumber(table.diffuse, 4), fixedNumber(table.glossy, 4), fixedNumber(table.kilobytes / 1000, 2)});
    }
    const Axis x{"normals in the table", true, false, diffuse.x}, y{"relative error of transfer", true};
    figure.plots = {{"plot-normal-tables", "Error of the nearest normal's operator", false, x, y, {diffuse, glossy}}};
    const NormalTable& last = comparison.normals.back();
    figure.finding = "With " + std::to_string(last.normals) + " normals the nearest one's operator is off by " +
                     percent(last.diffuse) + " of the transfer for a Lambertian surface and by " +
                     percent(last.glossy) + " for a glossy one, and the paper's operators take " +
                     fixedNumber(last.kilobytes / 1000, 1) +
                     " MB a material. In local frames one operator is exact for all normals.";
    figure.method = "Baked visibility of convention " + paper.name() +
                    " in the model frame, at up to 96 vertices in up to 8 held-out frames. The transfer under the "
                    "operator of the nearest of evenly spread normals is compared with that under the vertex' own "
                    "normal; the error is |difference| / |transfer| over vertices, frames and, for the glossy one, 4 "
                    "directions of view. It is the error of radiance under lights that are white in SH. A product "
                    "operator is kept as the paper stores it: 8 terms of n^2 (1 + n^2) 32-bit numbers.";
    return figure;
}

Figure lightsFigure(const Comparison& comparison) {
    Figure figure{"lights", "Lights and their 3 lobes", "Nowrouzezahrai 2009, figure 10"};
    figure.table.columns = {
        "light", "order", "greedy: error of SH", "greedy: of irradiance", "joint: error of SH", "joint: of irradiance"};
    Plot plot{"plot-lights", "Relative error of 3 lobes", true, {""}, {"relative error of SH", false, true}, {}};
    Series greedy{"greedy, as the paper", {0, false, false, true}}, joint{"joint, ours", {1, false, false, true}};
    double worst = 0;
    for (const LightPair& pair : comparison.lights) {
        figure.pictures += lightPairSvg(pair);
        for (Series* series : {&greedy, &joint}) series->x.push_back(double(plot.x.names.size()));
        plot.x.names.push_back(pair.name);
        greedy.y.push_back(pair.greedy.residual);
        joint.y.push_back(pair.joint.residual);
        worst = std::max(worst, pair.joint.residual);
        figure.table.rows.push_back({pair.name, std::to_string(pair.order), fixedNumber(pair.greedy.residual, 4),
                                     fixedNumber(pair.greedy.irradiance_error, 4), fixedNumber(pair.joint.residual, 4),
                                     fixedNumber(pair.joint.irradiance_error, 4)});
    }
    plot.series = {greedy, joint};
    figure.plots = {plot};
    figure.finding = "Three jointly fitted lobes leave at most " + percent(worst) + " of the SH of these lights.";
    figure.method =
        "Each row shows a light as SH, its 3 lobes as the paper finds them one after the other, and 3 lobes fitted "
        "together. All maps of a row have one exposure, and radiance below 0 is black. Up is +y, the middle is +x. The "
        "errors are |SH - lobes| / |SH| over all coefficients and channels, and the same of irradiance over all "
        "normals.";
    return figure;
}

Figure lobesFigure(const Comparison& comparison) {
    const LobeComparison& lobes = *comparison.lobes;
    Plot plot{"plot-lobes", "Held-out relative error", true, {}, {"relative error", false, true}};
    Series visibility{"visibility", {0, false, false, true}}, cosine{"with the cosine", {1, false, false, true}};
    Table table{
        {"model", "ridge", "lobes alone", "visibility, mean +- deviation", "with the cosine, mean +- deviation"}};
    for (const ComparedLobes& model : lobes.models) {
        const auto at = double(table.rows.size());
        plot.x.ticks.push_back(at);
        plot.x.names.push_back(model.name);
        for (const auto& [series, errors] :
             {std::pair(&visibility, &model.visibility), std::pair(&cosine, &model.cosine)}) {
            series->x.push_back(at);
            series->y.push_back(errors->mean);
            series->spread.push_back(errors->deviation);
        }
        table.rows.push_back({model.name, model.ridge > 0 ? shortest(model.ridge) : "-",
                              model.fitted > 0 ? fixedNumber(model.fitted, 3) : "-", errorText(model.visibility),
                              errorText(model.cosine)});
    }
    plot.series = {visibility, cosine};
    Figure figure{"lobes", "Zonal lobes of visibility", "Nowrouzezahrai 2008, figures 3 and 5", "", "", {plot}, table};
    const ComparedLobes &sh = lobes.models[0], &best = lobes.models.back();
    figure.finding = "A linear model of " + best.name + " has a held-out relative error of " +
                     fixedNumber(best.visibility.mean, 3) + ", that of SH " + fixedNumber(sh.visibility.mean, 3) +
                     "; with the cosine added again SH has " + fixedNumber(sh.cosine.mean, 3) +
                     ", fitted with the cosine in the data " + fixedNumber(lobes.models[1].cosine.mean, 3) + ".";
    figure.method =
        "Order " + std::to_string(lobes.order) + " of convention B, " + std::to_string(lobes.vertices) +
        " vertices, ridge regression on " + std::to_string(lobes.inputs) +
        " principal components of the joint angles. The lobes of every vertex and frame are fitted jointly from those "
        "of the vertex' mean, with a ridge towards their coefficients that folds of the training frames choose. Bars "
        "show the mean, and lines the deviation on either side. Mean and deviation are over held-out frames of |v^ - "
        "v| / |v|, all vertices together. \"With the cosine\" compares moments of V max(cos, 0).";
    return figure;
}

}  // namespace penumbra
