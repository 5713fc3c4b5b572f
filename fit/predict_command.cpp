// penumbra-fit predict X.model.h5 POSES.vis.h5 -o PRED.vis.h5: predicts visibility in the layout of a bake.
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/visibility/predict.h"

namespace penumbra {

namespace {

struct PredictCommand {
    std::string model, poses, output;
};

void define(CLI::App& app, PredictCommand& command) {
    app.add_option("model", command.model, "fitted model, X.model.h5")->required();
    app.add_option("poses", command.poses, "poses to predict, a bake of the same character")->required();
    app.add_option("-o,--output", command.output, "prediction to write, PRED.vis.h5")->required();
}

// Prints how far the poses are out of range. The measure is the root mean square of what was cut off the inputs
// (formats/stage/model_file.h). It is about the angle in radians by which whatever hides the sky is away from where
// training frames had it.
void printOutOfRange(const PredictReport& report) {
    double mean = 0, most = 0;
    std::size_t worst = 0;
    for (std::size_t f = 0; f < report.frames; ++f) {
        mean += report.out_of_range[f] / double(report.frames);
        if (report.out_of_range[f] > most) most = report.out_of_range[f], worst = f;
    }
    std::printf("%zu frames, out of the training range by %.4f on average, at most %.4f (frame %zu)\n", report.frames,
                mean, most, worst);
}

void run(const PredictCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const Model model = readModel(command.model);
    const VisibilityReader poses(command.poses);
    const std::size_t frames = poses.header().frames.frameCount();
    if (common.dry_run) {
        std::printf("would predict %zu frames of %zu vertices and write %s\n", frames, model.mesh.vertexCount(),
                    command.output.c_str());
        return;
    }
    report.phase("predict");
    Progress progress(common.quiet ? ProgressStyle::kNone : parseProgressStyle(common.progress), "predict", "frames",
                      double(frames));
    const Provenance provenance = makeProvenance("penumbra-fit predict", "{}", {command.model, command.poses});
    const PredictReport done = predictFile(model, poses, {command.poses, command.output, provenance}, common.threads,
                                           [&](double frame) { progress.update(frame); });
    report.figures["frames"] = done.frames;
    report.figures["out_of_range"] = done.out_of_range;
    if (!common.quiet) printOutOfRange(done);
}

}  // namespace

Verb predictVerb() {
    const auto command = std::make_shared<PredictCommand>();
    return {"predict",
            "Predicted visibility of the poses in a file, in the layout of a bake.",
            [command](CLI::App& app) { define(app, *command); },
            [command] {
                return std::vector<std::filesystem::path>{command->model, command->poses};
            },
            [command] { return std::filesystem::path(command->output); },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
