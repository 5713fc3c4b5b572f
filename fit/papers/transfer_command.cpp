// penumbra-fit transfer X.vis.h5 -o X.transfer.h5: fits a linear model of transfer to baked diffuse transfer.
#include <cmath>
#include <cstdio>
#include <memory>
#include <tuple>

#include "fit/papers/papers.h"
#include "fit/papers/transfer/fit_transfer.h"
#include "fit/report/run_report.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"

namespace penumbra {

namespace {

struct TransferCommand {
    std::string input, output;
    std::string components = "8,22", prior = "auto";
    TransferFitOptions options;

    std::vector<std::filesystem::path> inputs() const { return {input}; }
};

// Reads alpha; auto is none.
std::optional<double> readPrior(const std::string& text) {
    char* end = nullptr;
    const double alpha = std::strtod(text.c_str(), &end);
    if (text == "auto") return std::nullopt;
    if (text.empty() || *end != '\0' || !(alpha >= 0) || !std::isfinite(alpha))
        throw std::invalid_argument("must be auto or a number of 0 or more, not '" + text + "'");
    return alpha;
}

void define(CLI::App& app, TransferCommand& command) {
    TransferFitOptions& options = command.options;
    app.add_option("visibility_file", command.input,
                   "X.vis.h5 of --quantity transfer, or of visibility with one order more than --order")
        ->required();
    app.add_option("-o,--output", command.output, "model to write, X.transfer.h5")->required();
    addKind(app, "--model", options.model, kTransferModelKinds,
            "linear: from all joint angles to all vertices; pca: between components");
    app.add_option("--components", command.components, "components of the angles and of the vertices of --model pca");
    app.add_option("--order", options.order, "SH bands of the transfer")->check(within(1, 8));
    addKind(app, "--cross-validation", options.cross_validation, kCrossValidations,
            "what is left out to choose the prior: each frame (loo) or blocks of frames");
    const auto prior = [&command](const std::string& text) { return readPrior(command.prior = text); };
    addParsed(app, "--prior", options.prior, prior,
              "alpha of the ridge regression: a number, 0 for none, or auto for cross-validation")
        ->default_str("auto");
    addNameListOption(app, "--holdout", options.holdout, "clips that no step of the fit sees, for the errors");
}

TransferFitOptions resolveOptions(const TransferCommand& command, const CommonOptions& common) {
    TransferFitOptions options = command.options;
    if (options.model == TransferModelKind::kLinear && command.components != TransferCommand{}.components)
        throw UsageError("--components: only --model pca has them");
    std::tie(options.pose_components, options.vertex_components) = parseComponents(command.components);
    options.threads = common.threads;
    return options;
}

std::string optionsJson(const TransferCommand& command) {
    nlohmann::ordered_json json;
    const TransferFitOptions& options = command.options;
    json["model"] = nameOf(options.model);
    if (options.model == TransferModelKind::kPca) json["components"] = command.components;
    json["order"] = options.order;
    json["cross_validation"] = nameOf(options.cross_validation);
    json["prior"] = command.prior;
    json["holdout"] = options.holdout;
    return json.dump();
}

nlohmann::ordered_json errorsJson(const TransferErrors& errors) {
    return {{"relative_error", errors.relative_error},
            {"transfer_error", errors.transfer_error},
            {"relative_transfer_error", errors.relative_transfer_error}};
}

void reportFit(const TransferFit& fit, Report& report) {
    const TransferFitReport& found = fit.report;
    auto& figures = report.figures;
    figures["vertices"] = fit.model.mesh.vertexCount();
    figures["angles"] = fit.model.angles.size();
    figures["constant_angles"] = found.constant_angles;
    figures["train_frames"] = found.train_frames;
    figures["held_out_frames"] = found.held_out_frames;
    figures["alpha"] = fit.model.alpha;
    figures["largest_singular_value"] = found.largest_singular_value;
    figures["leave_one_out_relative_error"] = found.leave_one_out_error;
    figures["blocked_relative_error"] = found.blocked_error;
    figures["pose_variance"] = found.pose_variance;
    figures["vertex_variance"] = found.vertex_variance;
    figures["bytes"] = modelBytes(fit.model);
    figures["paper_bytes"] = paperBytes(fit.model);
    figures["paper_mesh_bytes"] = paperMeshBytes(fit.model);
    figures["train"] = errorsJson(found.train);
    if (found.held_out_frames) figures["held_out"] = errorsJson(found.held_out);
    for (const TransferClip& clip : found.clips) {
        figures["clips"][clip.clip] = errorsJson(clip.errors);
        figures["clips"][clip.clip]["held_out"] = clip.held_out;
    }
}

void printClip(const char* name, const char* role, std::size_t frames, const TransferErrors& errors) {
    std::printf("%-24s %-9s %6zu %14.4f %12.6f %18.4f\n", name, role, frames, errors.relative_error,
                errors.transfer_error, errors.relative_transfer_error);
}

void printFit(const TransferFit& fit) {
    const TransferFitReport& found = fit.report;
    std::printf("%zu joint angles (%zu more never change), %zu vertices, alpha %.4g (largest singular value %.4g)\n",
                fit.model.angles.size(), found.constant_angles, fit.model.mesh.vertexCount(), fit.model.alpha,
                found.largest_singular_value);
    if (fit.model.kind == TransferModelKind::kPca)
        std::printf("%zu components keep %.1f%% of the angles' variance, %zu keep %.1f%% of the transfer's\n",
                    fit.model.inputs(), 100 * found.pose_variance, fit.model.outputs(), 100 * found.vertex_variance);
    std::printf("%zu bytes as Nowrouzezahrai 2007 counts, %.2f%% of one mesh; %zu bytes with bias and mean\n",
                paperBytes(fit.model), 100 * double(paperBytes(fit.model)) / double(paperMeshBytes(fit.model)),
                modelBytes(fit.model));
    std::printf("%-24s %-9s %6s %14s %12s %18s\n", "clip", "", "frames", "relative error", "E_transfer",
                "relative E_transfer");
    for (const TransferClip& clip : found.clips)
        printClip(clip.clip.c_str(), clip.held_out ? "held out" : "train", clip.frames, clip.errors);
    printClip("all", "train", found.train_frames, found.train);
    if (found.held_out_frames) printClip("all", "held out", found.held_out_frames, found.held_out);
    std::printf("relative error of the maps, training frames: %.4f leave-one-out, %.4f blocked\n",
                found.leave_one_out_error, found.blocked_error);
}

void run(const TransferCommand& command, const CommonOptions& common, Report& report) {
    const TransferFitOptions options = resolveOptions(command, common);
    const VisibilityReader reader(command.input);
    checkTransferFit(reader.header(), command.input, options);
    if (common.dry_run) return printFitPlan(reader.header(), command.output);
    Progress progress = progressOf(common, "errors");
    TransferFit fit = fitTransfer(reader, command.input, options, observerOf(report, progress));
    report.phase("write");
    fit.model.provenance = makeProvenance("penumbra-fit transfer", optionsJson(command), {command.input});
    writeTransfer(command.output, fit.model);
    reportFit(fit, report);
    if (!common.quiet) printFit(fit);
}

}  // namespace

std::pair<std::size_t, std::size_t> parseComponents(const std::string& text) {
    unsigned pose = 0, vertices = 0;
    int length = 0;
    if (std::sscanf(text.c_str(), "%5u,%5u%n", &pose, &vertices, &length) != 2 || std::size_t(length) != text.size() ||
        pose < 1 || vertices < 1)
        throw UsageError("--components must be two numbers of 1 or more, like 8,22, not '" + text + "'");
    return {pose, vertices};
}

Verb transferVerb() {
    return verbOf<TransferCommand, const TransferCommand>(
        "transfer",
        "Fit a linear model of Nowrouzezahrai 2007 to baked diffuse transfer, as a function of the joint angles.",
        define, run);
}

}  // namespace penumbra
