// penumbra-pack truth X.vis.h5 -o X.truth.pnb: baked frames as they are.
#include <cstdio>

#include "formats/common/name_list_option.h"
#include "pack/named_input.h"
#include "pack/pack_truth.h"
#include "pack/pack_verbs.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

struct TruthCommand {
    fs::path input, output;
    std::string precision = "f16";
    TruthOptions options;
};

void runTruth(TruthCommand& command, const CommonOptions& common, Report& report) {
    command.options.precision = parsePrecision(command.precision);
    report.phase("read");
    const VisibilityReader reader(command.input);
    const TruthPlan plan = naming(command.input, [&] { return planTruth(reader, command.options); });
    report.figures["frames"] = plan.frames.size();
    report.figures["moment_bytes"] = plan.bytes;
    if (!common.quiet)
        std::printf("%s: %zu frames, %zu vertices, %.1f MB\n", command.output.c_str(), plan.frames.size(),
                    reader.header().mesh.vertexCount(), double(plan.bytes) * 1e-6);
    if (common.dry_run) return;
    report.phase("pack and write");
    nlohmann::ordered_json options;
    options["precision"] = command.precision;
    options["clips"] = command.options.clips;
    const std::string provenance = toJson(makeProvenance("penumbra-pack truth", options.dump(), {command.input}));
    Progress progress(parseProgressStyle(common.quiet ? "none" : common.progress), "packing truth", "frames",
                      double(std::max<std::size_t>(1, plan.frames.size())));
    naming(command.input, [&] {
        packTruth(reader, plan, command.options, provenance, command.output,
                  [&](std::size_t done) { progress.update(double(done)); });
    });
}

}  // namespace

Verb truthVerb() {
    const auto command = std::make_shared<TruthCommand>();
    return {
        "truth",
        "Pack baked frames as they are, for the player to show beside a model.",
        [command](CLI::App& app) {
            app.add_option("visibility", command->input, "X.vis.h5")->required();
            app.add_option("-o,--output", command->output, "X.truth.pnb")->required();
            app.add_option("--precision", command->precision, "of the moments")->check(CLI::IsMember({"f32", "f16"}));
            addNameListOption(app, "--clips", command->options.clips, "names of the clips to pack (default: all)");
        },
        [command] { return std::vector<fs::path>{command->input}; },
        [command] { return command->output; },
        [command](const CommonOptions& common, Report& report) { runTruth(*command, common, report); }};
}

}  // namespace penumbra
