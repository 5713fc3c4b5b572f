// penumbra-bake fields RIG... -o X.fields.h5: the flags and the run.
#include <chrono>
#include <cstdio>

#include "bake/bake_verbs.h"
#include "bake/fields/part_fields.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

struct FieldsCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, known after reading
    std::filesystem::path output;
    FieldOptions options;
    std::string parts, inputs, units = "m", up = "y";
    std::int64_t seed = std::int64_t(FieldOptions{}.seed);  // signed, so that -1 is refused instead of wrapping around
};

FrameRange parsePartRange(const std::string& text) try {
    const FrameRange range = parseFrameRange(text);
    if (range.step != 1 || range.begin >= range.end) throw UsageError("");
    return range;
} catch (const UsageError&) {
    throw UsageError("--parts takes A:B, the parts A, A + 1, ... below B, not '" + text + "'");
}

void finishOptions(FieldsCommand& command) {
    FieldOptions& options = command.options;
    if (!command.parts.empty()) options.parts = parsePartRange(command.parts);
    if (!command.inputs.empty()) options.inputs = command.inputs;
    if (command.seed < 0)
        throw UsageError("--seed must be 0..9223372036854775807, not " + std::to_string(command.seed));
    options.seed = std::uint64_t(command.seed);
    options.cache.metres = metresOfUnit(command.units);
    options.cache.z_up = upIsZ(command.up);
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
}

void reportPlan(const FieldPlan& plan, const FieldOptions& options, Report& report) {
    report.figures["parts"] = plan.file.fields.parts.size();
    report.figures["part_count"] = plan.file.partCount();
    report.figures["points"] = plan.pointCount();
    report.figures["rays"] = double(plan.pointCount()) * options.rays;
    report.figures["fade"] = plan.file.fields.fade;
}

void runFields(FieldsCommand& command, const CommonOptions& common, Report& report) {
    finishOptions(command);
    const ProgressStyle style = parseProgressStyle(common.quiet ? "none" : common.progress);
    report.phase("read");
    const auto start = std::chrono::steady_clock::now();
    const FieldPlan plan = planFields(command.rigs, command.options);
    command.files_read = plan.files_read;
    reportPlan(plan, command.options, report);
    if (common.dry_run) {
        std::printf("%zu of %zu parts, %zu points x %d rays\n", plan.file.fields.parts.size(), plan.file.partCount(),
                    plan.pointCount(), command.options.rays);
        return;
    }
    report.phase("trace");
    const FieldFile file = bakeFields(plan, command.options, common.threads, style);
    report.phase("write");
    writeFields(command.output, file);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    const std::uintmax_t bytes = std::filesystem::file_size(command.output);
    report.figures["seconds"] = seconds.count();
    report.figures["bytes"] = bytes;
    if (!common.quiet)
        std::printf("%s: %zu parts, %zu points x %d rays in %.1f s, %.2f MB\n", command.output.c_str(),
                    file.fields.parts.size(), plan.pointCount(), file.rays, seconds.count(), double(bytes) * 1e-6);
}

void defineFields(CLI::App& app, FieldsCommand& command) {
    FieldOptions& options = command.options;
    app.add_option("rig", command.rigs, "rig, or a mesh without skin, which is one part; only its rest pose matters")
        ->required();
    app.add_option("-o,--output", command.output, "X.fields.h5")->required();
    app.add_option("--rays", options.rays, "directions that each point is traced with");
    app.add_option("--seed", command.seed, "turns the set of directions");
    app.add_option("--cells", options.cells, "points along a side of the mean box, if it were a cube");
    app.add_option("--megabytes", options.megabytes,
                   "bound on all fields, in millions of bytes; takes fewer points to stay below");
    app.add_option("--fade", options.fade, "depth over which a point inside a part goes dark, in rest diagonals");
    app.add_option("--parts", command.parts, "A:B, half-open: these parts only, for a shard that merge puts together");
    app.add_option("--inputs", command.inputs, "FILE.csv of the bake, for an occluder that moves with a point of it");
    app.add_option("--units", command.units, "of a point cache: m, cm, mm, inch or metres (default: m)");
    app.add_option("--up", command.up, "of a point cache: y or z (default: y)");
}

}  // namespace

Verb fieldsVerb() {
    const auto command = std::make_shared<FieldsCommand>();
    return {"fields",
            "Trace how much of the sky each rigid part blocks, at any point around it.",
            [command](CLI::App& app) { defineFields(app, *command); },
            [command] { return command->files_read.empty() ? command->rigs : command->files_read; },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runFields(*command, common, report); }};
}

}  // namespace penumbra
