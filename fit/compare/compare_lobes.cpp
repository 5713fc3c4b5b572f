// The figure of Nowrouzezahrai 2008's lobes.
#include <cmath>

#include "fit/compare/compare_series.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

std::string errorText(const FrameSpread& errors) {
    if (!std::isfinite(errors.mean)) return "-";
    return fixedNumber(errors.mean, 3) + " +- " + fixedNumber(errors.deviation, 3);
}

}  // namespace

Figure lobesFigure(const Comparison& comparison) {
    const LobeComparison& lobes = *comparison.lobes;
    Plot plot{"plot-lobes", "Held-out relative error", true, {}, {"relative error", false, true, {}, {}}, {}};
    Series visibility{"visibility", {0, false, false, true}, {}, {}},
        cosine{"with the cosine", {1, false, false, true}, {}, {}};
    Table table{
        {"model", "ridge", "lobes alone", "visibility, mean +- deviation", "with the cosine, mean +- deviation"}, {}};
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
    figure.method = "Order " + std::to_string(lobes.order) + " of convention B, " + std::to_string(lobes.vertices) +
                    " vertices, ridge regression on " + std::to_string(lobes.inputs) +
                    " principal components of the joint angles. The lobes of every vertex and frame are fitted jointly "
                    "from those of the vertex' mean, with a ridge towards their coefficients that folds of the "
                    "training frames choose. Bars show the mean, and lines the deviation on either side. Mean and "
                    "deviation are over held-out frames of |v^ - v| / |v|, "
                    "all vertices together. \"With the cosine\" compares moments of V max(cos, 0).";
    return figure;
}

}  // namespace penumbra
