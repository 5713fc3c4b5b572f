// penumbra-bake merge SHARD... -o OUT: the flags and the run. It merges shards of bakes, or of fields.
#include <cstdio>

#include "bake/bake_verbs.h"
#include "bake/fields/merge_fields.h"
#include "bake/source/frame_choice.h"
#include "bake/visibility/merge_shards.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"

namespace penumbra {
namespace fs = std::filesystem;

namespace {
using Json = nlohmann::ordered_json;

struct MergeCommand {
    std::vector<fs::path> shards;
    fs::path output;
    MergeOptions options;
    bool index = false;  // --virtual

    std::vector<fs::path> inputs() const { return shards; }
};

void reportProblems(const MergeProblems& problems, Report& report) {
    report.figures["unreadable"] = problems.unreadable;
    report.figures["unusable"] = problems.unusable;
    report.figures["unsupported"] = problems.unsupported;
    report.figures["different"] = problems.different;
    report.figures["missing"] = Json::array();
    for (const ClipFrame& frame : problems.missing)
        report.figures["missing"].push_back({{"clip", frame.clip}, {"frame", frame.number}});
    report.figures["twice"] = problems.twice;
    report.figures["beyond"] = problems.beyond;
}

// Writes the output. When a shard turns out to be damaged, looks for damage in every shard, so that one run names all
// that has to be baked again.
void write(MergePlan& plan, const MergeCommand& command, const CommonOptions& common) try {
    if (command.index)
        writeIndex(plan, command.output, common.threads);
    else
        writeMerged(plan, command.output, common.progress);
} catch (const InvalidInput&) {
    findDamage(plan);
    if (!plan.problems.any()) throw;
}

void runMergeFields(const MergeCommand& command, const CommonOptions& common, Report& report) {
    if (!command.options.clips.empty() || command.options.frames || command.index)
        throw UsageError("--clips, --frames and --virtual are for shards of bakes, and these are shards of fields");
    refuseTwice(command.shards);
    report.phase("check");
    const FieldFile whole = mergeFields(command.shards);
    report.figures["shards"] = command.shards.size();
    report.figures["parts"] = whole.fields.parts.size();
    if (common.dry_run) {
        std::printf("%zu shards make %zu parts\n", command.shards.size(), whole.fields.parts.size());
        return;
    }
    report.phase("merge");
    writeFields(command.output, whole);
    const std::uintmax_t bytes = fs::file_size(command.output);
    report.figures["bytes"] = bytes;
    if (!common.quiet)
        std::printf("%s: %zu parts of %zu shards, %.2f MB\n", command.output.c_str(), whole.fields.parts.size(),
                    command.shards.size(), double(bytes) * 1e-6);
}

void runMerge(MergeCommand& command, const CommonOptions& common, Report& report) {
    if (anyHoldsFields(command.shards)) return runMergeFields(command, common, report);
    report.phase("check");
    MergePlan plan = planMerge(command.shards, command.options);
    if (plan.problems.any()) findDamage(plan);
    report.figures["shards"] = command.shards.size();
    report.figures["frames"] = plan.header.frames.frameCount();
    report.figures["vertices"] = plan.header.mesh.vertexCount();
    reportProblems(plan.problems, report);
    if (plan.problems.any()) plan.problems.raise();
    if (common.dry_run) {
        std::printf("%zu shards make %zu frames x %zu vertices\n", plan.shards.size(), plan.header.frames.frameCount(),
                    plan.header.mesh.vertexCount());
        return;
    }
    report.phase("merge");
    write(plan, command, common);
    reportProblems(plan.problems, report);
    if (plan.problems.any()) plan.problems.raise();
    const std::uintmax_t bytes = fs::file_size(command.output);
    report.figures["bytes"] = bytes;
    if (!common.quiet)
        std::printf("%s: %zu frames x %zu vertices of %zu shards, %.1f MB\n", command.output.c_str(),
                    plan.header.frames.frameCount(), plan.header.mesh.vertexCount(), plan.shards.size(),
                    double(bytes) * 1e-6);
}

void defineMerge(CLI::App& app, MergeCommand& command) {
    app.add_option("shard", command.shards, "bakes of one rig with --frames or --clips, or its fields with --parts")
        ->required();
    app.add_option("-o,--output", command.output, "X.vis.h5 or X.fields.h5")->required();
    addNameListOption(app, "--clips", command.options.clips,
                      "clips of the unsplit bake (default: those of the shards if they agree, else all)");
    app.add_flag("--virtual", command.index, "write a small index of the shards, which have to stay where they are");
    addFrames(app, command.options.frames, "frames A:B[:S] of the unsplit bake (default: all)");
}

}  // namespace

Verb mergeVerb() {
    Verb verb = verbOf<MergeCommand>(
        "merge", "Put shards together to the file that the unsplit bake makes; refuses gaps and overlaps.", defineMerge,
        runMerge);
    verb.checks_inputs = true;
    return verb;
}

}  // namespace penumbra
