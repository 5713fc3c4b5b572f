// The figures 2 to 5 and 7 and the tables 1 and 2 of Nowrouzezahrai 2007 on the user's own data.
#include <algorithm>
#include <cmath>

#include "fit/papers/compare/compare_series.h"
#include "fit/papers/compare/compare_transfer.h"

namespace penumbra {

namespace {

std::string nameOf(const TransferRun& run) { return run.name + (run.regularised ? "" : ", no prior"); }

// Returns the text of 23.6 MB, as the paper's table 2 has it.
std::string megabytes(std::size_t bytes) { return fixedNumber(double(bytes) / 1048576, 2) + " MiB"; }

const TransferRun* lowest(const TransferComparison& comparison, bool of_paper) {
    const TransferRun* best = nullptr;
    for (const TransferRun& run : comparison.runs)
        if (run.of_paper == of_paper && (!best || run.held_out.transfer_error < best->held_out.transfer_error))
            best = &run;
    return best;
}

Figure residualsFigure(const TransferRun& run) {
    const Residuals& residuals = *run.residuals;
    Figure figure{"residuals", "Residuals of the linear model", "Nowrouzezahrai 2007, figure 2"};
    Series density{"residuals", {0, false, true, false}}, cumulative = density;
    double below = 0;
    for (std::size_t i = 0; i < Residuals::kBins; ++i) {
        const double width = 2 * Residuals::kRange / double(Residuals::kBins);
        density.x.push_back((double(i) + 0.5) * width - Residuals::kRange);
        density.y.push_back(residuals.count[i] / residuals.total / width);
        cumulative.x.push_back(double(i + 1) * width - Residuals::kRange);
        cumulative.y.push_back((below += residuals.count[i]) / residuals.total);
    }
    const Axis x{"predicted - baked coefficient"};
    figure.plots = {{"plot-residuals", "Distribution", false, x, {"density", false, true}, {density}},
                    {"plot-residuals-cumulative",
                     "Empirical cumulative distribution",
                     false,
                     x,
                     {"share of the residuals", false, true},
                     {cumulative}}};
    char text[256];
    std::snprintf(text, sizeof text,
                  "The residuals of L over training frames have mean %.1e, median %.1e and variance %.2e (the paper's: "
                  "5.1e-05, 0 and 3.25e-04).",
                  residuals.mean(), residuals.median(), residuals.variance());
    figure.finding = text;
    figure.method = "All coefficients of all vertices in all training frames. The outer bins hold what lies beyond.";
    return figure;
}

Figure priorFigure(const TransferComparison& comparison) {
    Figure figure{"prior", "With and without regularisation", "Nowrouzezahrai 2007, figure 3"};
    Plot plot{"plot-prior", "Errors with and without prior", true, {}, {"E_transfer", false, true}};
    figure.table.columns = {"model", "alpha", "train", "held out", "train, no prior", "held out, no prior"};
    std::array<Series, 4> series{Series{"train", {0, false, false, true}}, Series{"held out", {1, false, false, true}},
                                 Series{"train, no prior", {0, true, false, true}},
                                 Series{"held out, no prior", {1, true, false, true}}};
    for (const TransferRun& run : comparison.runs) {
        if (!run.of_paper || !run.regularised) continue;
        const auto without = std::ranges::find_if(
            comparison.runs, [&](const TransferRun& other) { return other.name == run.name && !other.regularised; });
        if (without == comparison.runs.end()) continue;
        const std::array<double, 4> values{run.train.transfer_error, run.held_out.transfer_error,
                                           without->train.transfer_error, without->held_out.transfer_error};
        for (std::size_t i = 0; i < 4; ++i) {
            series[i].x.push_back(double(plot.x.names.size()));
            series[i].y.push_back(values[i]);
        }
        plot.x.names.push_back(run.name);
        std::vector<std::string> row{run.name, shortNumber(run.alpha)};
        for (const double value : values) row.push_back(fixedNumber(value, 5));
        figure.table.rows.push_back(row);
        figure.finding += (figure.finding.empty() ? "" : " ") + run.name +
                          ": the prior takes the held-out error from " + fixedNumber(values[3], 5) + " to " +
                          fixedNumber(values[1], 5) + ", and the training error from " + fixedNumber(values[2], 5) +
                          " to " + fixedNumber(values[0], 5) + ".";
    }
    plot.series.assign(series.begin(), series.end());
    figure.plots = {plot};
    figure.method =
        "Models of few components, and L. Alpha is the one with the least error when each training frame is left out "
        "in turn (Nowrouzezahrai 2007, section 4.2).";
    return figure;
}

Plot decayPlot(const std::string& id, const EigenvalueDecay& decay, int colour) {
    Series series = decaySeries(decay, colour);
    series.style.marks = decay.shares.size() < 24;
    return {id, decay.name, false, {"component", true}, {"share of the variance", true}, {series}};
}

Figure decayFigure(const TransferComparison& comparison) {
    Figure figure{"eigenvalues", "Eigenvalues of angles and of transfer", "Nowrouzezahrai 2007, figure 4"};
    figure.plots = {decayPlot("plot-decay-angles", comparison.pose_decay, 0),
                    decayPlot("plot-decay-transfer", comparison.transfer_decay, 1)};
    figure.table = decayTable({comparison.pose_decay, comparison.transfer_decay}, {0.5, 0.9, 0.99, 0.999});
    figure.finding = "90% of the variance takes " + figure.table.rows[0][2] + " components of the angles and " +
                     figure.table.rows[1][2] + " of the transfer (the paper's: 8 and 22).";
    figure.method =
        "PCA over training frames. The rows of the second have the numbers of all vertices for one coefficient in one "
        "frame, so that one basis serves all coefficients.";
    return figure;
}

Figure picturesFigure(const TransferComparison& comparison) {
    Figure figure{"pictures", "A held-out frame", "Nowrouzezahrai 2007, figures 4 and 5"};
    std::string names = "the bake";
    for (const TransferRun& run : comparison.runs)
        if (!run.pictured.empty()) names += ", " + run.name;
    figure.finding = "Frame " + std::to_string(comparison.pictured_frame) + " of the bake, in " +
                     comparison.pictured_clip + ". From left to right: " + names + ".";
    figure.method =
        "Above: diffuse, albedo 1, one soft light from the upper left and a dim sky. Below: white less four times the "
        "root of E_transfer over pi, so that darker is worse.";
    return figure;
}

Figure bouncesFigure(const BouncesComparison& comparison) {
    Figure figure{"bounces", "Light that bounces", "Nowrouzezahrai 2007, figure 7"};
    figure.table.columns = {"model", "train", "held out", "held out, of all indirect light", "bytes"};
    const BouncedRun *paper = nullptr, *ours = nullptr;
    const auto add = [&](const std::string& name, double train, double held_out, const std::string& bytes) {
        figure.table.rows.push_back({name, fixedNumber(train, 4), fixedNumber(held_out, 4),
                                     fixedNumber(held_out / comparison.without_held_out, 3), bytes});
    };
    add("no light that bounces", comparison.without_train, comparison.without_held_out, "0");
    std::string names = "the bake";
    for (const BouncedRun& run : comparison.runs) {
        add(run.name, run.train, run.held_out, std::to_string(run.bytes));
        const BouncedRun*& best = run.of_paper ? paper : ours;
        if (!best || run.held_out < best->held_out) best = &run;
        names += ", " + run.name;
    }
    figure.finding = "Without light that bounces " + percent(comparison.without_held_out) +
                     " of direct transfer is missing in held-out clips. Of Nowrouzezahrai 2007's models " +
                     paper->name + " leaves the least, " + percent(paper->held_out);
    if (ours) figure.finding += "; \"" + ours->name + "\" leaves " + percent(ours->held_out);
    figure.finding += ".";
    figure.method =
        "Errors of the indirect transfer of " + std::to_string(comparison.bounces) + " bounces, order " +
        std::to_string(comparison.order) +
        ", in three colour channels: rms of the error over rms of the direct transfer. The paper's models have maps "
        "for each channel, and their bytes are those of three. Ours have bands 0 to 2. The picture shows frame " +
        std::to_string(comparison.pictured_frame) + " of " + comparison.pictured_clip +
        " with albedo 1: all light above, and below three times the light that bounced. From left to right: " + names +
        ".";
    return figure;
}

Figure costFigureOf(const TransferComparison& comparison) {
    Figure figure{"cost", "What the models cost", "Nowrouzezahrai 2007, table 1"};
    figure.table.columns = {"model", "megaops a frame", "ms a frame", "Hz", "fit, s", "of it PCA, s"};
    const TransferRun* fastest = nullptr;
    for (const TransferRun& run : comparison.runs) {
        if (!run.regularised) continue;
        figure.table.rows.push_back({run.name, run.of_paper ? fixedNumber(run.megaops, 2) : "-",
                                     fixedNumber(run.frame_ms, 3), fixedNumber(1000 / run.frame_ms, 0),
                                     fixedNumber(run.fit_seconds, 1),
                                     run.pca_seconds > 0 ? fixedNumber(run.pca_seconds, 1) : "-"});
        if (run.of_paper && (!fastest || run.frame_ms < fastest->frame_ms)) fastest = &run;
    }
    figure.finding = fastest->name +
                     " is the fastest of the paper's models: " + fixedNumber(1000 / fastest->frame_ms, 0) +
                     " frames a second on one thread (the paper's PCA(8,22): 105).";
    figure.method =
        "Operations as the paper counts them (an addition 1, a multiplication 2), of one coefficient. Times of the "
        "paper's models are from the pose to shading with the light multiplied in first, and of models of visibility "
        "from the pose to their numbers, by the fit's own code on one thread; penumbra-player bench times the run "
        "time.";
    return figure;
}

Figure storageFigure(const TransferComparison& comparison) {
    Figure figure{"storage", "What the models take", "Nowrouzezahrai 2007, table 2"};
    figure.table.columns = {"model", "bytes", "size", "% of all data", "% of one mesh"};
    const double data = double(comparison.frame_bytes) * double(comparison.train_frames);
    std::string finding;
    for (const TransferRun& run : comparison.runs) {
        if (!run.regularised) continue;
        const double mesh = 100 * double(run.bytes) / double(comparison.frame_bytes);
        figure.table.rows.push_back({run.name, std::to_string(run.bytes), megabytes(run.bytes),
                                     fixedNumber(100 * double(run.bytes) / data, 3), fixedNumber(mesh, 2)});
        finding += (finding.empty() ? "" : ", ") + run.name + " takes " + fixedNumber(mesh, 1) + "%";
    }
    figure.finding = "Of the transfer of one pose, " + finding + ".";
    figure.method =
        "32-bit numbers. The paper's models are counted as the paper counts them: L without its bias, reduced ones "
        "without the mean. Of models of visibility all numbers count, but not the fields of a composed one.";
    return figure;
}

}  // namespace

Table transferSummary(const TransferComparison& comparison) {
    Table table{{"model", "E_transfer, train", "held out", "relative E, train", "relative E, held out",
                 "relative error, model frame", "relative error, local frames"}};
    for (const TransferRun& run : comparison.runs)
        table.rows.push_back(
            {nameOf(run), fixedNumber(run.train.transfer_error, 5), fixedNumber(run.held_out.transfer_error, 5),
             fixedNumber(run.train.relative_transfer_error, 4), fixedNumber(run.held_out.relative_transfer_error, 4),
             fixedNumber(run.held_out.relative_error, 4), fixedNumber(run.local_held_out, 4)});
    return table;
}

std::string transferFinding(const TransferComparison& comparison) {
    const TransferRun *paper = lowest(comparison, true), *ours = lowest(comparison, false);
    std::string text = "On held-out clips " + nameOf(*paper) + " has the least E_transfer of the linear models, " +
                       fixedNumber(paper->held_out.transfer_error, 5);
    if (ours)
        text += "; the model of visibility \"" + ours->name + "\" has " +
                fixedNumber(ours->held_out.transfer_error, 5) + ", " +
                fixedNumber(ours->held_out.transfer_error / paper->held_out.transfer_error, 2) + " times that";
    return text + ".";
}

std::vector<Figure> transferFigures(const TransferComparison& comparison) {
    std::vector<Figure> figures;
    for (const TransferRun& run : comparison.runs)
        if (run.residuals) figures.push_back(residualsFigure(run));
    figures.push_back(priorFigure(comparison));
    figures.push_back(decayFigure(comparison));
    figures.push_back(picturesFigure(comparison));
    if (comparison.bounces) figures.push_back(bouncesFigure(*comparison.bounces));
    figures.push_back(costFigureOf(comparison));
    figures.push_back(storageFigure(comparison));
    return figures;
}

}  // namespace penumbra
