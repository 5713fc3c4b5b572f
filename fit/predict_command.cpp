// penumbra-fit predict X.model.h5 POSES.vis.h5 -o PRED.vis.h5: predicts visibility in the layout of a bake.
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/lobes/predict_lobe_file.h"
#include "fit/transfer/predict_transfer.h"
#include "fit/visibility/predict.h"
#include "formats/stage/stage_file_kind.h"
#include "formats/stage/transfer_file.h"

namespace penumbra {

namespace {

struct PredictCommand {
    std::string model, poses, output;
};

void define(CLI::App& app, PredictCommand& command) {
    app.add_option("model", command.model, "fitted model, X.model.h5, X.lobes.h5 or X.transfer.h5")->required();
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

Provenance provenanceOf(const PredictCommand& command) {
    return makeProvenance("penumbra-fit predict", "{}", {command.model, command.poses});
}

Progress progressOf(const CommonOptions& common, std::size_t frames) {
    return {common.quiet ? ProgressStyle::kNone : parseProgressStyle(common.progress), "predict", "frames",
            double(frames)};
}

void printDryRun(const PredictCommand& command, const VisibilityReader& poses) {
    std::printf("would predict %zu frames of %zu vertices and write %s\n", poses.header().frames.frameCount(),
                poses.header().mesh.vertexCount(), command.output.c_str());
}

// Predicts with a linear model of transfer.
void runTransfer(const PredictCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const TransferModel model = readTransfer(command.model);
    const VisibilityReader poses(command.poses);
    checkCharacter(model, poses.header(), command.poses);
    if (common.dry_run) return printDryRun(command, poses);
    report.phase("predict");
    const std::size_t frames = poses.header().frames.frameCount();
    Progress progress = progressOf(common, frames);
    predictTransferFile(model, poses, {command.output, provenanceOf(command), common.threads},
                        [&](double frame) { progress.update(frame); });
    report.figures["frames"] = frames;
    if (!common.quiet) std::printf("%zu frames of diffuse transfer\n", frames);
}

// Predicts with a model of Nowrouzezahrai 2008.
void runLobes(const PredictCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const LobeModel model = readLobes(command.model);
    const VisibilityReader poses(command.poses);
    checkCharacter(model, poses.header(), command.poses);
    if (common.dry_run) return printDryRun(command, poses);
    report.phase("predict");
    const std::size_t frames = poses.header().frames.frameCount();
    Progress progress = progressOf(common, frames);
    predictLobeFile(model, poses, {command.output, provenanceOf(command), common.threads},
                    [&](double frame) { progress.update(frame); });
    report.figures["frames"] = frames;
    if (!common.quiet) std::printf("%zu frames of %zu zonal lobes a vertex\n", frames, model.lobes);
}

void run(const PredictCommand& command, const CommonOptions& common, Report& report) {
    const std::string kind = stageFileKind(command.model);
    if (kind == "penumbra.transfer") return runTransfer(command, common, report);
    if (kind == "penumbra.lobes") return runLobes(command, common, report);
    report.phase("read");
    const Model model = readModel(command.model);
    const VisibilityReader poses(command.poses);
    if (common.dry_run) return printDryRun(command, poses);
    report.phase("predict");
    Progress progress = progressOf(common, poses.header().frames.frameCount());
    const PredictReport done = predictFile(model, poses, {command.poses, command.output, provenanceOf(command)},
                                           common.threads, [&](double frame) { progress.update(frame); });
    report.figures["frames"] = done.frames;
    report.figures["out_of_range"] = done.out_of_range;
    if (!common.quiet) printOutOfRange(done);
}

}  // namespace

Verb predictVerb() {
    const auto command = std::make_shared<PredictCommand>();
    return {"predict",
            "Predicted visibility or transfer of the poses in a file, in the layout of a bake.",
            [command](CLI::App& app) { define(app, *command); },
            [command] {
                return std::vector<std::filesystem::path>{command->model, command->poses};
            },
            [command] { return std::filesystem::path(command->output); },
            [command](const CommonOptions& common, Report& report) { run(*command, common, report); }};
}

}  // namespace penumbra
