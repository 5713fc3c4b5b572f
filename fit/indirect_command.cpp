// penumbra-fit indirect X.model.h5 X.transfer.vis.h5 -o X.lit.model.h5: adds the light that bounces to a model of
// visibility.
#include <cstdio>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/report/run_report.h"
#include "fit/visibility/fit_indirect.h"
#include "formats/common/options.h"
#include "formats/common/pass_rig_options.h"

namespace penumbra {

namespace {

struct IndirectCommand {
    std::string model, bake, output;
    IndirectFitOptions options;

    std::vector<std::filesystem::path> inputs() const { return {model, bake}; }
};

void define(CLI::App& app, IndirectCommand& command) {
    app.add_option("model", command.model, "X.model.h5 of penumbra-fit visibility")->required();
    app.add_option("bake", command.bake, "X.vis.h5 of --quantity transfer --bounces N: frames of the model's own bake")
        ->required();
    app.add_option("-o,--output", command.output, "the model with light that bounces, to write")->required();
    app.add_option("--output-variance", command.options.output_variance,
                   "share of the indirect transfer's variance to keep, (0, 1]")
        ->check(aShare());
}

nlohmann::ordered_json sharesJson(const IndirectShares& shares, double relative_error) {
    return {{"relative_error", relative_error},
            {"share_of_direct", shares.model},
            {"share_of_direct_by_mean", shares.mean},
            {"share_of_direct_without", shares.without},
            {"ambient_error", shares.ambient_error}};
}

void reportFit(const IndirectFit& fit, Report& report) {
    const IndirectReport& found = fit.report;
    std::size_t components = 0;
    for (const ClusterModel& cluster : fit.model.clusters) components += cluster.components();
    report.figures["bounces"] = fit.model.bounces;
    report.figures["components"] = components;
    report.figures["train_frames"] = found.train_frames;
    report.figures["held_out_frames"] = found.held_out_frames;
    report.figures["train"] = sharesJson(found.train, found.train_error);
    if (found.held_out_frames) report.figures["held_out"] = sharesJson(found.held_out, found.held_out_error);
    report.figures["cross_validated_relative_error"] = found.cross_validated_error;
}

void printRow(const char* role, std::size_t frames, double relative_error, const IndirectShares& shares) {
    std::printf("%-9s %6zu %14.4f %13.4f %10.4f %10.4f %10.4f\n", role, frames, relative_error, shares.ambient_error,
                shares.without, shares.mean, shares.model);
}

void printFit(const IndirectFit& fit) {
    const IndirectReport& found = fit.report;
    std::printf("%-9s %6s %14s %13s %32s\n%-9s %6s %14s %13s %10s %10s %10s\n", "", "", "", "",
                "error as a share of direct light", "", "frames", "relative error", "ambient error", "no bounces",
                "mean", "model");
    printRow("train", found.train_frames, found.train_error, found.train);
    if (found.held_out_frames) printRow("held out", found.held_out_frames, found.held_out_error, found.held_out);
    std::printf("relative error, training frames: %.4f blocked cross-validation\n", found.cross_validated_error);
}

void run(const IndirectCommand& command, const CommonOptions& common, Report& report) {
    IndirectFitOptions options = command.options;
    options.threads = common.threads;
    Model model = readModel(command.model);
    const VisibilityReader reader(command.bake);
    checkIndirectFit(model, reader.header(), command.bake);
    if (common.dry_run) return printFitPlan(reader.header(), command.output);
    Progress progress = progressOf(common, "fit");
    IndirectFit fit = fitIndirect(model, reader, command.bake, options, observerOf(report, progress));
    report.phase("write");
    reportFit(fit, report);
    if (!common.quiet) printFit(fit);
    model.indirect = std::move(fit.model);
    nlohmann::ordered_json made;
    made["output_variance"] = options.output_variance;
    passRigOptions(model.provenance.options_json, made);
    model.provenance = makeProvenance("penumbra-fit indirect", made.dump(), command.inputs());
    writeModel(command.output, model);
}

}  // namespace

Verb indirectVerb() {
    return verbOf<IndirectCommand, const IndirectCommand>(
        "indirect", "Add the light that bounces, from a bake of transfer, to a model of visibility.", define, run);
}

}  // namespace penumbra
