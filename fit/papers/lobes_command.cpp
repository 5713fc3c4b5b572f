// The run of `penumbra-fit visibility --model zh-lobes`, whose flags are with those of other models.

#include <cstdio>

#include "fit/papers/lobes/fit_lobe_model.h"
#include "fit/papers/papers.h"
#include "fit/report/run_report.h"
#include "formats/common/options.h"

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
        "lobes alone leave %.4f of the visibility; the model, mean and deviation over frames: train %.4f +- %.4f",
        fit.report.fitted, fit.report.train_spread.mean, fit.report.train_spread.deviation);
    if (fit.report.held_out_frames)
        std::printf(", held out %.4f +- %.4f", fit.report.held_out_spread.mean, fit.report.held_out_spread.deviation);
    std::printf("\n");
}

// Takes what lobes have of the options of all models.
LobeFitOptions optionsOf(const LobesCommand& command, const FitOptions& shared) {
    const CLI::App& app = *command.app;
    for (const char* name : {"--fields", "--local-model", "--parts", "--output-variance"})
        if (app.count(name) > 0) throw UsageError(std::string(name) + " cannot be combined with --model zh-lobes");
    if (app.count("--features") > 0 && shared.features != FeatureKind::kJointAngles)
        throw UsageError(std::string("--features ") + nameOf(shared.features) +
                         ": --model zh-lobes reads only joint-angles");
    LobeFitOptions options;
    if (app.count("--convention") > 0) {
        if (shared.convention.below != BelowHorizon::kBlocked || shared.convention.order < 2)
            throw UsageError("--convention " + shared.convention.name() + ": --model zh-lobes takes B2 to B" +
                             std::to_string(kMaxOrder) + ", visibility that is 0 below the horizon");
        options.order = shared.convention.order;
    }
    options.lobes = command.lobes;
    options.clusters = shared.clusters;
    if (shared.input_variance > 0) options.input_variance = shared.input_variance;
    options.holdout = shared.holdout;
    options.train_frames = shared.train_frames;
    options.threads = shared.threads;
    return options;
}

}  // namespace

void addLobesOption(CLI::App& app, int& lobes) {
    lobes = LobeFitOptions{}.lobes;
    app.add_option("--lobes", lobes, "zonal lobes of a vertex, of --model zh-lobes")
        ->check(within(1, kMaxVisibilityLobes));
}

void runLobes(const LobesCommand& command, const FitOptions& shared, const CommonOptions& common, Report& report) {
    const LobeFitOptions options = optionsOf(command, shared);
    const VisibilityReader reader(command.input);
    const VisibilityHeader& header = reader.header();
    checkLobeFit(header, command.input, options);
    if (common.dry_run) return printFitPlan(header, command.output);
    Progress progress = progressOf(common, "fit");
    LobeModelFit fit = fitLobeModel(reader, options, observerOf(report, progress));
    report.phase("write");
    fit.model.provenance = makeProvenance("penumbra-fit visibility", optionsJson(options), command.inputs);
    writeLobes(command.output, fit.model);
    fillReport(fit, header.frames, report);
    if (!common.quiet) printFit(fit, header.frames);
}

}  // namespace penumbra
