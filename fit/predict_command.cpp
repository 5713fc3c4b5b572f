// penumbra-fit predict X.model.h5 POSES.vis.h5 -o PRED.vis.h5: predicts visibility in the layout of a bake.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/papers/papers.h"
#include "fit/report/run_report.h"

namespace penumbra {

namespace {

void define(CLI::App& app, PredictCommand& command) {
    app.add_option("model", command.model, "fitted model, X.model.h5, X.lobes.h5 or X.transfer.h5")->required();
    app.add_option("poses", command.poses, "poses to predict, a bake of the same character")->required();
    app.add_option("-o,--output", command.output, "prediction to write, PRED.vis.h5")->required();
}

// Prints how far the poses are out of range. The measure is the root mean square of what was cut off the inputs
// (formats/stage/model_file.h). It is about the angle in radians by which whatever hides the sky is away from where
// training frames had it.
void printOutOfRange(const std::vector<double>& out_of_range) {
    double mean = 0;
    for (const double one : out_of_range) mean += one / double(out_of_range.size());
    const auto worst = std::ranges::max_element(out_of_range);
    std::printf("%zu frames, out of the training range by %.4f on average, at most %.4f (frame %zu)\n",
                out_of_range.size(), mean, *worst, std::size_t(worst - out_of_range.begin()));
}

void run(const PredictCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    if (predictWithPaperModel(command, common, report)) return;
    const Model model = readModel(command.model);
    std::vector<double> out_of_range;
    const PosePredictor predictor{[&](const VisibilityHeader& poses) { checkCharacter(model, poses, command.poses); },
                                  [&](const VisibilityReader& poses, const PredictionOutput& to) {
                                      out_of_range = predictFile(model, poses, to);
                                  }};
    if (runPredict(command, predictor, common, report) == 0) return;
    report.figures["out_of_range"] = out_of_range;
    if (!common.quiet) printOutOfRange(out_of_range);
}

}  // namespace

Verb predictVerb() {
    return verbOf<PredictCommand, const PredictCommand>(
        "predict", "Predicted visibility or transfer of the poses in a file, in the layout of a bake.", define, run);
}

}  // namespace penumbra
