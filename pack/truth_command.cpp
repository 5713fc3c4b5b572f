// penumbra-pack truth X.vis.h5 -o X.truth.pnb: baked frames as they are.
#include <cstdio>

#include "formats/common/options.h"
#include "pack/named_input.h"
#include "pack/pack_truth.h"
#include "pack/pack_verbs.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

constexpr Word<AssetPrecision> kMomentWords[] = {{"f32", AssetPrecision::kF32}, {"f16", AssetPrecision::kF16}};

struct TruthCommand {
    fs::path input, output;
    TruthOptions options;

    std::vector<fs::path> inputs() const { return {input}; }
};

void runTruth(TruthCommand& command, const CommonOptions& common, Report& report) {
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
    options["precision"] = nameOf(command.options.precision);
    options["clips"] = command.options.clips;
    const std::string provenance = toJson(makeProvenance("penumbra-pack truth", options.dump(), {command.input}));
    Progress progress(common.progress, "packing truth", "frames", double(std::max<std::size_t>(1, plan.frames.size())));
    naming(command.input, [&] {
        packTruth(reader, plan, command.options, provenance, command.output,
                  [&](std::size_t done) { progress.update(double(done)); });
    });
}

void defineTruth(CLI::App& app, TruthCommand& command) {
    app.add_option("visibility", command.input, "X.vis.h5")->required();
    app.add_option("-o,--output", command.output, "X.truth.pnb")->required();
    addChoice(app, "--precision", command.options.precision, kMomentWords, "precision of the moments");
    addNameListOption(app, "--clips", command.options.clips, "names of the clips to pack (default: all)");
}

}  // namespace

Verb truthVerb() {
    return verbOf<TruthCommand>("truth", "Pack baked frames as they are, for the player to show beside a model.",
                                defineTruth, runTruth);
}

}  // namespace penumbra
