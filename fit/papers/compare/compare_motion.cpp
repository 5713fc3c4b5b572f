// Figures of the poses and of the visibility themselves: one vertex as one joint turns, and eigenvalues.
#include <algorithm>
#include <cmath>

#include "fit/papers/compare/compare_series.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

std::vector<double> inDegrees(std::vector<double> angles) {
    for (double& angle : angles) angle = degrees(angle);
    return angles;
}

Series bakedSeries(const JointSweep& sweep, bool held_out) {
    Series series{held_out ? "baked, held-out clips" : "baked, training clips",
                  {held_out ? 7 : 6, held_out, false, true}};
    for (std::size_t f = 0; f < sweep.baked_angles.size(); ++f) {
        if (sweep.baked_held_out[f] != held_out) continue;
        series.x.push_back(degrees(sweep.baked_angles[f]));
        series.y.push_back(sweep.baked_ambient[f]);
    }
    return series;
}

// Returns the root mean square, over all frames, of the curve at the frame's angle minus the frame's E.
double distanceFromPoints(const JointSweep& sweep, const std::vector<double>& curve) {
    const double step = (sweep.angles.back() - sweep.angles.front()) / double(sweep.angles.size() - 1);
    double sum = 0;
    for (std::size_t f = 0; f < sweep.baked_angles.size(); ++f) {
        const double at = step > 0 ? (sweep.baked_angles[f] - sweep.angles.front()) / step : 0;
        const std::size_t i = std::min(std::size_t(std::max(at, 0.0)), curve.size() - 2);
        const double value = curve[i] + (at - double(i)) * (curve[i + 1] - curve[i]);
        sum += (value - sweep.baked_ambient[f]) * (value - sweep.baked_ambient[f]);
    }
    return std::sqrt(sum / double(sweep.baked_angles.size()));
}

}  // namespace

Figure jointFigure(const Comparison& comparison) {
    const JointSweep& sweep = *comparison.sweep;
    Plot plot{"plot-joint",
              "Vertex " + std::to_string(sweep.vertex) + " as " + sweep.joint_name + " turns",
              false,
              {"angle of " + sweep.joint_name + " about its main axis, degrees"},
              {"ambient visibility E"}};
    plot.series = {bakedSeries(sweep, false), bakedSeries(sweep, true)};
    Table table{{"model", "rms distance from the baked points", "least E of the curve", "largest E of the curve"}};
    std::string closest;
    double least = INFINITY;
    const auto add = [&](const std::string& name, SeriesStyle style, const std::vector<double>& y) {
        if (y.empty()) return;
        style.marks = false;
        plot.series.push_back({name, style, inDegrees(sweep.angles), y});
        const auto [low, high] = std::minmax_element(y.begin(), y.end());
        const double distance = distanceFromPoints(sweep, y);
        table.rows.push_back({name, fixedNumber(distance, 4), fixedNumber(*low, 3), fixedNumber(*high, 3)});
        if (distance >= least) return;
        least = distance;
        closest = name;
    };
    for (const CompareFit& fit : comparison.fits)
        add(labelOf(fit.options.model, fit.options.features), styleOf(fit.options.model, fit.options.features),
            fit.turn_ambient);
    for (const VectorFit& fit : comparison.vectors)  // the lower degrees are the linear and the quadratic model
        if (fit.degree == kMaxDegree && fit.prior) add(labelOf(fit), styleOf(fit), fit.turn_ambient);
    Figure figure{"joint", "One vertex as one joint turns", "Nowrouzezahrai 2009, figure 6", "", "", {plot}, table};
    figure.finding = "The angle of " + sweep.joint_name + " alone explains " + percent(sweep.explained) +
                     " of the variance of E at vertex " + std::to_string(sweep.vertex) +
                     " over training frames; the curve of " + closest + " comes closest to the baked points, " +
                     fixedNumber(least, 3) + " rms.";
    figure.method =
        "Points: all baked frames, in which every joint moves, hence the scatter. Curves: the models' predictions for "
        "poses that no one baked: the joint turns about the main axis of its motion, everything else stays as in the "
        "training frame nearest to the mean pose. Joint and vertex are the pair (of up to 1,500 vertices) where a "
        "function of one angle explains most.";
    return figure;
}

Figure eigenvaluesFigure(const Comparison& comparison) {
    Figure figure{"eigenvalues", "Eigenvalues of poses and of visibility", "Nowrouzezahrai 2007, figure 4"};
    const Axis x{"component", true}, y{"share of the variance", true};
    Plot inputs{"plot-eigenvalues-inputs", "Poses", false, x, y},
        outputs{"plot-eigenvalues-outputs", "Visibility", false, x, y};
    std::vector<EigenvalueDecay> decays = comparison.inputs;
    decays.insert(decays.end(), comparison.outputs.begin(), comparison.outputs.end());
    std::string at_ninety;
    for (std::size_t i = 0; i < decays.size(); ++i) {
        (i < comparison.inputs.size() ? inputs : outputs).series.push_back(decaySeries(decays[i], int(i)));
        at_ninety += (i == 0 ? "" : ", ") + componentsText(decays[i], 0.9) + " (" + decays[i].name + ")";
    }
    figure.table = decayTable(decays, {0.5, 0.8, 0.9, 0.95, 0.99, 0.999});
    figure.plots = {inputs, outputs};
    figure.finding = "90% of the variance takes these numbers of components: " + at_ninety + ".";
    figure.method =
        "PCA over training frames. Bone features are weighted as the fit weighs them; the visibility is that of "
        "convention " +
        comparison.options.referenceConvention().name() +
        ", clusters are those of the reference. Nowrouzezahrai 2007 stacks a row a pose and number, which has one "
        "column a vertex, and finds one basis for all numbers; of these components the largest 200 are computed.";
    return figure;
}

}  // namespace penumbra
