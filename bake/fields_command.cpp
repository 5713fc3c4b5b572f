// penumbra-bake fields RIG... -o X.fields.h5: the flags and the run.
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "bake/bake_verbs.h"
#include "bake/cache_flags.h"
#include "bake/fields/part_fields.h"
#include "bake/rig_flags.h"
#include "formats/common/warning.h"

namespace penumbra {

namespace {

struct FieldsCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, known after reading
    std::filesystem::path output;
    FieldOptions options;

    std::vector<std::filesystem::path> inputs() const { return files_read.empty() ? rigs : files_read; }
};

FrameRange parsePartRange(const std::string& text) {
    const FrameRange range = parseFrameRange(text);
    if (range.step != 1)
        throw std::invalid_argument("must be A:B, the parts A, A + 1, ... below B, not '" + text + "'");
    return range;
}

void reportPlan(const FieldPlan& plan, const FieldOptions& options, Report& report) {
    report.figures["parts"] = plan.file.fields.parts.size();
    report.figures["part_count"] = plan.file.partCount();
    report.figures["points"] = plan.pointCount();
    report.figures["rays"] = double(plan.pointCount()) * options.rays;
    report.figures["fade"] = plan.file.fields.fade;
}

// Reports how far the fields are from rays, and warns of each that is too far. Returns a line for the user.
std::string reportErrors(const FieldFile& file, const FieldErrors& errors, Report& report) {
    const auto worst = std::size_t(std::max_element(errors.part.begin(), errors.part.end()) - errors.part.begin());
    for (std::size_t p = 0; p < errors.part.size(); ++p) {
        report.figures["errors"]["parts"].push_back({{"part", file.partName(p)}, {"rms_v", errors.part[p]}});
        if (errors.part[p] > kMaxFieldRms)
            reportWarning("penumbra-bake", fieldWarning(file.partName(p), errors.part[p]));
    }
    report.figures["errors"]["rms_v"] = errors.product;
    char text[160];
    std::snprintf(text, sizeof text, "fields against rays: rms V %.4f of all far parts, at most %.4f of one",
                  errors.product, errors.part[worst]);
    return text + (" ('" + file.partName(worst) + "')");
}

void runFields(FieldsCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const auto start = std::chrono::steady_clock::now();
    const FieldPlan plan = planFields(command.rigs, command.options);
    command.files_read = plan.files_read;
    reportNotes(plan.notes, report);
    reportPlan(plan, command.options, report);
    if (common.dry_run) {
        std::printf("%zu of %zu parts, %zu points x %d rays\n", plan.file.fields.parts.size(), plan.file.partCount(),
                    plan.pointCount(), command.options.rays);
        return;
    }
    report.phase("trace");
    const FieldFile file = bakeFields(plan, command.options, common.threads, common.progress);
    report.phase("compare");
    const std::size_t first_part = file.shard ? file.shard->first_part : 0;
    const FieldErrors errors = compareFields(plan.receivers, file.fields, first_part, common.threads);
    report.phase("write");
    writeFields(command.output, file);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    const std::uintmax_t bytes = std::filesystem::file_size(command.output);
    report.figures["seconds"] = seconds.count();
    report.figures["bytes"] = bytes;
    if (!common.quiet)
        std::printf("%s: %zu parts, %zu points x %d rays in %.1f s, %.2f MB\n", command.output.c_str(),
                    file.fields.parts.size(), plan.pointCount(), file.rays, seconds.count(), double(bytes) * 1e-6);
    if (plan.receivers.poses.empty()) return;
    const std::string line = reportErrors(file, errors, report);
    if (!common.quiet) std::printf("%s\n", line.c_str());
}

void defineFields(CLI::App& app, FieldsCommand& command) {
    FieldOptions& options = command.options;
    app.add_option("rig", command.rigs, "rig, or a mesh without skin, which is one part; only its rest pose matters")
        ->required();
    app.add_option("-o,--output", command.output, "X.fields.h5")->required();
    app.add_option("--rays", options.rays, "directions that each point is traced with")
        ->check(within(16, 1 << 16, "directions a point"));
    addSeed(app, options.seed, "turns the set of directions");
    app.add_option("--cells", options.cells, "points along a side of the mean box, if it were a cube")
        ->check(within(4, 64, "points along a side"));
    app.add_option("--megabytes", options.megabytes,
                   "bound on all fields, in millions of bytes; takes fewer points to stay below")
        ->check(within(0.01, 1000.0, "million bytes"));
    app.add_option("--fade", options.fade, "depth over which a point inside a part goes dark, in rest diagonals")
        ->check(within(1e-6, 1.0, "diagonals of the rest positions"));
    addParsed(app, "--parts", options.parts, parsePartRange,
              "A:B, half-open: these parts only, for a shard that merge puts together");
    addFile(app, "--inputs", options.inputs, "FILE.csv of the bake, for an occluder that moves with a point of it");
    addCacheFlags(app, options.cache);
    addRigFlags(app, options.rig);
}

}  // namespace

Verb fieldsVerb() {
    return verbOf<FieldsCommand>("fields", "Trace how much of the sky each rigid part blocks, at any point around it.",
                                 defineFields, runFields);
}

}  // namespace penumbra
