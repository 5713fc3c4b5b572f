// penumbra-pack export X.vis.h5|X.pnb [RIG.glb] -o OUT: occlusion as files that other programs take as they are.
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "formats/asset/mapped_file.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/source/source_readers.h"
#include "pack/export/export_files.h"
#include "pack/named_input.h"
#include "pack/pack_verbs.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

constexpr Word<ExportKind> kKindWords[] = {{"static", ExportKind::kStatic},
                                           {"play", ExportKind::kPlay},
                                           {"table", ExportKind::kTable},
                                           {"npy", ExportKind::kNumpy}};

struct ExportCommand {
    fs::path input, rig, output;
    ExportOptions options;
    const CLI::Option* kind = nullptr;
    const CLI::Option *components = nullptr, *max_error = nullptr;
    bool no_color = false, level = false, bounced = false, bent = false, positions = false;

    std::vector<fs::path> inputs() const { return namedFiles({input, rig}); }
};

// Returns the kind that the name of the output asks for.
ExportKind kindOfName(const fs::path& output) {
    if (isExtension(output, ".npy")) return ExportKind::kNumpy;
    if (isExtension(output, ".png") || isExtension(output, ".exr")) return ExportKind::kTable;
    if (isExtension(output, ".glb")) return ExportKind::kStatic;
    throw UsageError("--output must end in .glb, .png, .exr or .npy, not " + output.string());
}

void finishOptions(ExportCommand& command) {
    ExportOptions& options = command.options;
    const ExportKind by_name = kindOfName(command.output);
    if (command.kind->count() == 0) options.kind = by_name;
    const auto given = [](const CLI::Option* option) { return option->count() > 0; };
    const bool into_glb = options.kind == ExportKind::kStatic || options.kind == ExportKind::kPlay;
    const bool fits =
        into_glb ? by_name == ExportKind::kStatic
                 : options.kind == by_name || (options.kind == ExportKind::kTable && by_name == ExportKind::kStatic);
    if (!fits)
        throw UsageError("--as " + std::string(wordOf(kKindWords, options.kind)) + " does not write " +
                         command.output.string());
    if (command.rig.empty() && by_name == ExportKind::kStatic)
        throw UsageError("an export into a .glb needs the .glb of the character as a second file");
    for (const CLI::Option* option : {command.components, command.max_error})
        if (given(option) && options.kind != ExportKind::kPlay)
            throw UsageError(option->get_name() + " needs --as play");
    if (command.no_color && options.kind != ExportKind::kStatic) throw UsageError("--no-color needs --as static");
    if (command.level && command.rig.empty()) throw UsageError("--lod needs the .glb of a level of detail");
    if (command.bent && options.kind != ExportKind::kTable) throw UsageError("--bent needs --as table");
    if (command.bounced && options.kind != ExportKind::kTable && options.kind != ExportKind::kStatic)
        throw UsageError("--bounced needs --as static or --as table");
    if (command.positions &&
        (options.kind != ExportKind::kNumpy || !command.rig.empty() || options.rate > 0 || !options.clips.empty()))
        throw UsageError("--positions needs --as npy and all frames of a bake");
    if (given(command.max_error) && !given(command.components)) options.components = 0;
    if (command.no_color) options.color = ColorAttribute::kNone;
    if (command.level) options.mesh = ExportMesh::kLevel;
    if (command.bent) options.value = TableValue::kBent;
    if (command.bounced) options.value = TableValue::kBounced;
}

// The files behind a source, which must stay where they are.
struct OpenSource {
    std::unique_ptr<MappedFile> file;
    AssetView asset;
    std::unique_ptr<VisibilityReader> bake;
    std::unique_ptr<OcclusionSource> source;
};

bool isAsset(const fs::path& path) {
    char magic[8] = {};
    std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
    return std::string(magic + 4, 4) == "PNB1";
}

std::unique_ptr<OpenSource> openSource(const ExportCommand& command, const Rig* rig) {
    const ExportOptions& options = command.options;
    auto out = std::make_unique<OpenSource>();
    if (isAsset(command.input)) {
        out->file = std::make_unique<MappedFile>(command.input);
        out->asset = openAsset(out->file->bytes(), command.input.string());
        const double rate = options.rate > 0 ? options.rate : kModelRate;
        if (rig)
            out->source = naming(command.rig, [&] { return modelOcclusion(out->asset, rig, options.clips, rate); });
        else
            out->source = modelOcclusion(out->asset, nullptr, options.clips, rate);
        if (rig) return out;
    } else {
        out->bake = std::make_unique<VisibilityReader>(command.input);
        out->source = naming(command.input, [&] { return bakedOcclusion(*out->bake, options.clips); });
    }
    const FrameList& frames = out->source->frames();
    double rate = options.rate;
    // The rows of a table are equally far apart.
    if (rate == 0 && options.kind == ExportKind::kTable && !hasSteadyRate(frames)) rate = meanRate(frames);
    if (rate > 0) out->source = resampledOcclusion(std::move(out->source), rate);
    return out;
}

void sayNotes(const std::vector<std::string>& notes, Report& report) {
    for (const std::string& note : notes) {
        reportWarning("penumbra-pack", note);
        report.figures["notes"].push_back(note);
    }
}

ExportRows rowsOf(const ExportCommand& command, const OcclusionSource& source, const Rig* rig, int threads,
                  Report& report) {
    if (!rig) return ownRows(source);
    const ExportRows rows = naming(command.rig, [&] { return matchRows(source, *rig, command.options.mesh, threads); });
    std::vector<std::string> notes;
    if (rows.by_place > 0)
        notes.push_back(command.rig.string() + ": has other vertices than " + command.input.string() + ": " +
                        std::to_string(rows.by_place) + " were found by their places");
    for (const std::string& slot : rows.left_out)
        notes.push_back(command.rig.string() + ": '" + slot + "' is not in " + command.input.string() +
                        " and stays as it is");
    sayNotes(notes, report);
    report.figures["matched_by_place"] = rows.by_place;
    if (command.options.mesh == ExportMesh::kLevel) report.figures["max_distance_diagonals"] = rows.max_distance;
    return rows;
}

// Writes the .glb and tells what became larger.
void writeGlbOf(const fs::path& path, const ExportedGlb& out, const CommonOptions& common, Report& report) {
    const std::vector<std::byte> bytes = bytesOf(out.glb);
    double before = 0;
    for (const fs::path& file : out.glb.files_read) before += double(fs::file_size(file));
    writeWholeFile(path, bytes);
    std::size_t vertices = 0;
    for (const GlbTarget& target : out.targets) vertices += out.rig.part_colors[target.parts[0]].vertices;
    report.figures["primitives"] = out.targets.size();
    report.figures["vertices"] = vertices;
    report.figures["bytes"] = bytes.size();
    report.figures["added_bytes"] = double(bytes.size()) - before;
    if (!common.quiet)
        std::printf("%s: %zu vertices in %zu primitives, %.1f kB, of which %.1f kB are added\n", path.c_str(), vertices,
                    out.targets.size(), double(bytes.size()) * 1e-3, (double(bytes.size()) - before) * 1e-3);
}

void reportPatterns(const PrincipalWeights& patterns, const CommonOptions& common, Report& report) {
    const std::size_t all = patterns.rms_of_count.size() - 1;
    report.figures["components"] = patterns.count;
    report.figures["all_components"] = all;
    report.figures["rms_error"] = patterns.rms;
    report.figures["max_error"] = patterns.max;
    report.figures["rms_of_mean"] = patterns.rms_of_count[0];
    if (!common.quiet)
        std::printf("%zu of %zu components: rms error of occlusion %.4f, max %.3f (the mean alone: rms %.4f)\n",
                    patterns.count, all, patterns.rms, patterns.max, patterns.rms_of_count[0]);
}

// Inputs that all kinds of export share.
struct ExportJob {
    const ExportCommand& command;
    const FrameReader& frames;
    const ExportRows& rows;
    const CommonOptions& common;
    Report& report;
};

void reportMean(double rms, const ExportJob& job) {
    job.report.figures["rms_of_mean"] = rms;
    if (!job.common.quiet)
        std::printf("mean of %zu frames, from which they differ by %.4f rms\n", job.frames.source.frames().frameCount(),
                    rms);
}

void writeTable(const ExportJob& job, ExportedGlb* glb) {
    const TableFiles files = tableFiles(job.command.output, glb ? TableGlb::kWritten : TableGlb::kNone);
    std::vector<fs::path> others;
    for (const fs::path& file : {files.picture, files.description, files.glb})
        if (!file.empty() && file != job.command.output) others.push_back(file);
    job.report.willWrite(others);
    const TableLayout layout = exportTable(job.frames, job.rows, job.command.options.value, files, glb);
    job.report.figures["picture"] = {{"width", layout.width}, {"height", layout.height()}};
    if (!job.common.quiet)
        std::printf("%s: %zu x %zu texels, %.1f kB: %zu frames of %zu vertices, %zu rows a frame\n",
                    files.picture.c_str(), layout.width, layout.height(), double(fs::file_size(files.picture)) * 1e-3,
                    layout.frames, layout.vertices, layout.rows_a_frame);
    if (glb) writeGlbOf(files.glb, *glb, job.common, job.report);
}

void exportIntoGlb(const ExportJob& job, const Rig& rig) {
    const fs::path& path = job.command.rig;
    const GltfNumbers numbers(path);
    ExportedGlb out{rig, job.rows, numbers, openGrowingGlb(path), {}};
    std::vector<fs::path> others;  // files that the reader of the rig has not reported yet
    for (const fs::path& file : out.glb.files_read)
        if (std::find(rig.files_read.begin(), rig.files_read.end(), file) == rig.files_read.end())
            others.push_back(file);
    job.report.willRead(others);
    const ExportOptions& options = job.command.options;
    try {
        out.targets = findTargets(rig, job.rows, out.glb);
        if (options.kind == ExportKind::kStatic) reportMean(exportStatic(job.frames, options, out), job);
        if (options.kind == ExportKind::kPlay)
            reportPatterns(exportPlay(job.frames, options, out), job.common, job.report);
        if (options.kind == ExportKind::kTable) writeTable(job, &out);
    } catch (const nlohmann::json::exception& error) {
        throw InvalidInput(path.string() + ": is not valid glTF: " + error.what());
    }
    sayNotes(out.glb.notes, job.report);
    if (options.kind != ExportKind::kTable) writeGlbOf(job.command.output, out, job.common, job.report);
}

void runJob(const ExportJob& job, const Rig* rig) {
    if (job.command.options.kind == ExportKind::kNumpy) {
        exportNumpy(job.frames, job.rows, job.command.output);
        if (!job.common.quiet)
            std::printf("%s: %zu frames of %zu vertices\n", job.command.output.c_str(),
                        job.frames.source.frames().frameCount(), job.rows.count());
    } else if (rig) {
        exportIntoGlb(job, *rig);
    } else {
        writeTable(job, nullptr);
    }
}

void runExport(ExportCommand& command, const CommonOptions& common, Report& report) {
    finishOptions(command);
    report.phase("read");
    std::optional<Rig> rig;
    if (!command.rig.empty()) {
        rig = readRig({command.rig});
        report.willRead({rig->files_read.begin() + 1, rig->files_read.end()});
    }
    const Rig* given = rig ? &*rig : nullptr;
    const std::unique_ptr<OpenSource> open = openSource(command, given);
    report.phase("match");
    const ExportRows rows = rowsOf(command, *open->source, given, common.threads, report);
    const std::size_t count = open->source->frames().frameCount();
    report.figures["frames"] = count;
    report.figures["rows"] = rows.count();
    if (common.dry_run) {
        std::printf("%s: %zu frames of %zu vertices\n", command.output.c_str(), count, rows.count());
        return;
    }
    report.phase("export");
    Progress progress(common.progress, "exporting", "frames", double(std::max<std::size_t>(1, count)));
    const FrameReader frames{*open->source, common.threads, [&](std::size_t done) { progress.update(double(done)); }};
    if (command.positions && !open->bake) throw InvalidInput(command.input.string() + ": --positions are a bake's");
    if (command.positions)
        exportPositions(*open->bake, rows, command.output);
    else
        runJob({command, frames, rows, common, report}, given);
}

void defineExport(CLI::App& app, ExportCommand& command) {
    ExportOptions& options = command.options;
    app.add_option("input", command.input, "X.vis.h5, whose frames are exported, or X.pnb, whose model is asked")
        ->required();
    app.add_option("rig", command.rig, "RIG.glb of the character; from X.pnb any clip of it");
    app.add_option("-o,--output", command.output, "OUT.glb, .png, .exr or .npy")->required();
    command.kind = addChoice(app, "--as", options.kind, kKindWords,
                             "static: mean in vertex attributes; play: vertex colours that follow the clips; table: "
                             "picture with a row for each frame; npy: array of NumPy (default: by the name of OUT)");
    addNameListOption(app, "--clips", options.clips, "names of the clips (default: all)");
    app.add_option("--rate", options.rate, "frames a second (default: the bake's, or 12 for a model)")
        ->check(within(0.01, 1000.0, "frames a second"));
    CLI::Option* components = app.add_option("--components", options.components, "morph targets of --as play; 0: all")
                                  ->check(within(0, 100000, "morph targets"));
    command.max_error = app.add_option("--max-error", options.max_error,
                                       "as few morph targets as keep the rms error of occlusion below this")
                            ->check(within(1e-6, 1.0, "of occlusion"))
                            ->excludes(components);
    command.components = components;
    app.add_flag("--no-color", command.no_color, "leave COLOR_0 alone and write _OCCLUSION and nothing else");
    CLI::Option* bounced = app.add_flag("--bounced", command.bounced, "light that bounces, too, in COLOR_0 and tables");
    app.add_flag("--bent", command.bent, "tables of bent normals, with occlusion as alpha")->excludes(bounced);
    app.add_flag("--positions", command.positions,
                 "with --as npy: the positions of the bake's vertices instead of their occlusion");
    app.add_flag("--lod", command.level, "RIG is a level of detail: it takes the values of the nearest surface");
}

}  // namespace

Verb exportVerb() {
    return verbOf<ExportCommand>("export", "Write occlusion as files that other programs take as they are.",
                                 defineExport, runExport);
}

}  // namespace penumbra
