#include "fit/visibility_lobes.h"

#include <cstdio>

#include "fit/clip_table.h"

namespace penumbra {

namespace {

std::string optionsJson(const LobeFitOptions& options) {
    nlohmann::ordered_json json;
    json["model"] = kZhLobes;
    json["lobes"] = options.lobes;
    json["clusters"] = options.clusters ? std::to_string(options.clusters) : "auto";
    json["input_variance"] = options.input_variance;
    json["holdout"] = options.holdout;
    json["convention"] = Convention{BelowHorizon::kBlocked, options.order}.name();
    return json.dump();
}

ClipTable tableOf(const LobeModelFit& fit, const FrameList& frames) {
    const LobeFitReport& report = fit.report;
    return {frames, fit.model.clip_errors, report.train_frames, report.held_out_frames, report.train, report.held_out};
}

nlohmann::ordered_json toJson(const FrameSpread& spread) {
    return {{"mean", spread.mean}, {"deviation", spread.deviation}};
}

void fillReport(const LobeModelFit& fit, const FrameList& frames, Report& report) {
    auto& figures = report.figures;
    figures["vertices"] = fit.model.mesh.vertexCount();
    figures["lobes"] = fit.model.lobes;
    figures["inputs"] = fit.model.inputs();
    figures["ridge"] = fit.model.ridge;
    figures["bytes"] = modelBytes(fit.model);
    figures["lobes_alone"] = fit.report.fitted;
    figures["train_spread"] = toJson(fit.report.train_spread);
    if (fit.report.held_out_frames) figures["held_out_spread"] = toJson(fit.report.held_out_spread);
    addToReport(tableOf(fit, frames), figures);
}

void printFit(const LobeModelFit& fit, const FrameList& frames) {
    const LobeModel& model = fit.model;
    std::printf("%zu lobes a vertex, %zu inputs, ridge %g, %zu bytes (%.0f a vertex)\n", model.lobes, model.inputs(),
                model.ridge, modelBytes(model), double(modelBytes(model)) / double(model.mesh.vertexCount()));
    print(tableOf(fit, frames));
    std::printf(
        "lobes alone leave %.4f of the visibility; the model, mean and deviation over frames: train %.4f +- "
        "%.4f",
        fit.report.fitted, fit.report.train_spread.mean, fit.report.train_spread.deviation);
    if (fit.report.held_out_frames)
        std::printf(", held out %.4f +- %.4f", fit.report.held_out_spread.mean, fit.report.held_out_spread.deviation);
    std::printf("\n");
}

}  // namespace

void runLobes(const LobesCommand& command, const CommonOptions& common, Report& report) {
    const VisibilityReader reader(command.input);
    const VisibilityHeader& header = reader.header();
    checkLobeFit(header, command.input, command.options);
    if (common.dry_run) {
        std::printf("would fit %zu frames of %zu vertices and write %s\n", header.frames.frameCount(),
                    header.mesh.vertexCount(), command.output.c_str());
        return;
    }
    Progress progress(common.quiet ? ProgressStyle::kNone : parseProgressStyle(common.progress), "fit", "%", 100);
    FitObserver observer;
    observer.phase = [&](const char* name) { report.phase(name); };
    observer.progress = [&](double share) { progress.update(100 * share); };
    LobeModelFit fit = fitLobeModel(reader, command.options, observer);
    report.phase("write");
    fit.model.provenance = makeProvenance("penumbra-fit visibility", optionsJson(command.options), command.inputs);
    writeLobes(command.output, fit.model);
    fillReport(fit, header.frames, report);
    if (!common.quiet) printFit(fit, header.frames);
}

}  // namespace penumbra
