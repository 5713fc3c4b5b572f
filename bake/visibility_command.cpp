// penumbra-bake visibility RIG... -o X.vis.h5: ray-traced visibility of every vertex over an animation.
#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "bake/bake_verbs.h"
#include "bake/cache_flags.h"
#include "bake/rig_flags.h"
#include "bake/source/frame_choice.h"
#include "bake/source/surface_colors.h"
#include "bake/visibility/bake_estimate.h"
#include "formats/cache/numbered_files.h"
#include "formats/common/errors.h"
#include "formats/common/warning.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024e-6;  // Linux counts in KiB
}

constexpr Word<Precision> kPrecisionWords[] = {{"f32", Precision::kFloat32}, {"f16", Precision::kFloat16}};
constexpr Word<bool> kQuantityWords[] = {{"visibility", false}, {"transfer", true}};

struct VisibilityCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, known after reading
    std::filesystem::path output;
    std::filesystem::path converted;  // --keep-converted; "": not asked for
    BakeOptions options;
    const CLI::Option* ground = nullptr;
    bool local = false;
    LocalMoments local_moments;
    bool of_transfer = false;
    TransferOptions transfer;
    std::vector<const CLI::Option*> transfer_options;  // only allowed with --quantity transfer
    bool resume = false;

    // The files that were read. Before that is known, those that the command names, without patterns and folders of
    // numbered files.
    std::vector<std::filesystem::path> inputs() const {
        if (!files_read.empty()) return files_read;
        std::vector<std::filesystem::path> files = singleFilesOf(options.occluders);
        std::copy_if(rigs.begin(), rigs.end(), std::back_inserter(files),
                     [](const std::filesystem::path& rig) { return !namesSequence(rig); });
        for (const auto& file : {options.poses, options.inputs}) files.push_back(file.value_or(""));
        return namedFiles(files);
    }
};

// Reads `--ground`, which stands alone or has a height.
std::optional<double> readGround(const std::string& text) {
    if (text == "rest") return std::nullopt;
    double height = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, height);
    if (error != std::errc() || stop != end || !std::isfinite(float(height)))
        throw std::invalid_argument("must be a height in metres, rest or nothing, not '" + text +
                                    "'; put it behind the files where it has no height");
    return height;
}

void finishOptions(VisibilityCommand& command) {
    BakeOptions& options = command.options;
    options.ground = command.ground->count() > 0;
    if (command.local) options.local = command.local_moments;
    if (command.of_transfer) options.transfer = command.transfer;
    for (const CLI::Option* option : command.transfer_options)
        if (!command.of_transfer && option->count() > 0)
            throw UsageError(option->get_name() + " needs --quantity transfer");
    if (options.transfer && options.local) throw UsageError("--local needs --quantity visibility");
    if (options.poses && options.fps > 0 && options.clips.empty())
        throw UsageError("--fps needs --clips beside --poses, which has times of its own");
    refuseTwice(command.rigs);
}

std::string asJson(const std::vector<std::string>& names) {
    return nlohmann::ordered_json(names).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void reportPlan(const BakePlan& plan, const BakeOptions& options, Report& report) {
    report.figures["frames"] = plan.header.frames.frameCount();
    report.figures["vertices"] = plan.header.mesh.vertexCount();
    if (plan.header.drawn) report.figures["drawn_vertices"] = plan.header.drawn->mesh.vertexCount();
    report.figures["triangles"] = plan.header.mesh.triangles.size();
    report.figures["rays"] = plan.rays();
    report.figures["uncompressed_bytes"] = plan.bytes(options.precision);
    if (!plan.albedo_from.empty()) report.figures["albedo_from"] = plan.albedo_from;
}

void printEstimate(const BakeEstimate& estimate, int threads, Report& report) {
    report.figures["estimated_seconds"] = estimate.seconds;
    report.figures["estimated_bytes"] = estimate.bytes;
    report.figures["estimated_memory_bytes"] = estimate.memory;
    report.figures["estimated_journal_bytes"] = estimate.journal;
    std::printf(
        "estimate from a probe of %.1f s: %.0f s on %d threads, %.1f MB, peak memory %.0f MB, journal %.1f MB\n",
        estimate.probe_seconds, estimate.seconds, threads, estimate.bytes * 1e-6, estimate.memory * 1e-6,
        estimate.journal * 1e-6);
}

// A mesh whose triangles face inwards hides the whole sky from itself, and everything that is made of it is black.
void warnIfDark(const VisibilityCommand& command, const BakeResult& result) {
    constexpr double kDark = 0.02;  // figures and animals have 0.4 to 0.8
    if (result.open_share >= kDark) return;
    char text[120];
    std::snprintf(text, sizeof text, ": the mean vertex sees %.1f%% of its sky; do the triangles face inwards?",
                  100 * result.open_share);
    reportWarning("penumbra-bake", command.output.string() + text);
}

void runVisibility(VisibilityCommand& command, const CommonOptions& common, Report& report) {
    const BakeOptions& options = command.options;
    finishOptions(command);
    report.phase("read");
    const BakePlan plan = planBake(command.rigs, options);
    command.files_read = plan.files_read;
    reportNotes(plan.notes(), report);
    if (plan.source.rig) logReaders(plan.source.rig->log, report);
    reportPlan(plan, options, report);
    if (common.dry_run) {
        std::printf("%zu frames x %zu vertices x %d rays = %.1f Mray; %.1f MB before compression\n",
                    plan.header.frames.frameCount(), plan.header.mesh.vertexCount(), options.rays, plan.rays() * 1e-6,
                    plan.bytes(options.precision) * 1e-6);
        std::printf("clips: %s\n", asJson(plan.header.frames.clip_names).c_str());
        if (!plan.albedo_from.empty()) std::printf("albedo: %s\n", plan.albedo_from.c_str());
        report.phase("probe");
        printEstimate(estimateBake(plan, options, common.threads), common.threads, report);
        return;
    }
    if (!command.converted.empty()) report.willWrite({command.converted});
    writeConverted(command.converted, plan.source.rig ? &*plan.source.rig : nullptr, command.rigs.front());
    if (std::string damage; command.resume && isWhole(command.output, plan, damage)) {
        report.figures["already_whole"] = true;
        if (!common.quiet) std::printf("%s: is this bake already, and is complete\n", command.output.c_str());
        return;
    } else if (!damage.empty() && !common.quiet) {
        reportWarning("penumbra-bake", damage + ": all of it is baked anew");
    }
    report.phase("trace and write");
    const BakeResult result =
        bakeVisibility(plan, options, {command.output, command.resume ? Journal::kResume : Journal::kFresh},
                       common.threads, common.progress);
    if (!result.note.empty() && !common.quiet) reportWarning("penumbra-bake", result.note);
    warnIfDark(command, result);
    const double rate = result.rays_traced / result.seconds;
    report.figures["frames_resumed"] = result.frames_kept;
    if (!result.note.empty()) report.figures["journal"] = result.note;
    report.figures["rays_traced"] = result.rays_traced;
    report.figures["rays_per_second"] = rate;
    report.figures["open_share"] = result.open_share;
    report.figures["bytes"] = result.written_bytes;
    report.figures["peak_rss_megabytes"] = peakMegabytes();
    if (plan.header.hasBounces()) {
        report.figures["hit_share"] = result.hit_share;
        report.figures["back_share_of_hits"] = result.back_share;
        if (!common.quiet)
            std::printf("%.1f%% of the rays hit a surface; %.2f%% of these hits were backs, which reflect nothing\n",
                        100 * result.hit_share, 100 * result.back_share);
    }
    if (!common.quiet && result.frames_kept > 0)
        std::printf("went on after %zu of %zu frames\n", result.frames_kept, plan.header.frames.frameCount());
    if (!common.quiet)
        std::printf("%s: %zu frames x %zu vertices, %.1f Mray in %.1f s (%.2f Mray/s), %.1f MB, peak memory %.0f MB\n",
                    command.output.c_str(), plan.header.frames.frameCount(), plan.header.mesh.vertexCount(),
                    result.rays_traced * 1e-6, result.seconds, rate * 1e-6, result.written_bytes * 1e-6,
                    peakMegabytes());
}

void defineVisibility(CLI::App& app, VisibilityCommand& command) {
    BakeOptions& options = command.options;
    app.add_option("rig", command.rigs, "rig or point cache; further files may bring clips only")->required();
    app.add_option("-o,--output", command.output, "X.vis.h5")->required();
    addNameListOption(app, "--clips", options.clips, "names of the clips to bake (default: all)");
    app.add_option("--fps", options.fps, "samples a second (default: the clips' own keys)")
        ->check(within(0.0, 1000.0, "samples a second"));
    addFrames(app, options.frames, "A:B[:S], half-open, of the sampled frames of all chosen clips");
    app.add_option("--blocks", options.blocks,
                   "cut every clip into this many blocks of equal length, clips NAME#1, NAME#2, ... (to hold one out)")
        ->check(within(1, 10000, "blocks of every clip"));
    addCacheFlags(app, options.cache);
    addRigFlags(app, options.rig);
    addKeepConverted(app, options.rig, command.converted);
    app.add_option("--cache-fps", options.cache.fps,
                   "keys a second of a point cache (default: as its file says, else 24)")
        ->check(within(0.0, 999999.0, "keys a second"));
    addFile(app, "--poses", options.poses, "X.poses.h5 of `penumbra-bake poses`: these frames, then those of --clips");
    app.add_option("--points", options.points,
                   "bake so many chosen points of a dense character; all other vertices interpolate between them "
                   "(default: bake all)")
        ->check(within(16, 1 << 24, "points"));
    app.add_option("--order", options.order, "SH bands")->check(within(1, kMaxOrder, "bands"));
    app.add_option("--rays", options.rays, "directions above the horizon")
        ->check(within(16, 1 << 16, "directions above the horizon"));
    addSeed(app, options.seed, "turns the set of directions");
    app.add_option("--bias", options.bias, "start of a ray above the surface, in rest diagonals")
        ->check(within(1e-7, 0.1, "diagonals of the rest pose"));
    addChoice(app, "--precision", options.precision, kPrecisionWords, "precision of the coefficients on disk");
    app.add_flag("--resume", command.resume,
                 "go on where a killed bake of this output stopped; keep what is done when stopped");
    command.ground = addParsed(app, "--ground", options.ground_y, readGround,
                               "an infinite floor blocks every direction that points down; its height, or rest: the "
                               "lowest point at rest")
                         ->expected(0, 1)
                         ->default_str("rest")
                         ->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    app.add_option("--distance", options.distance,
                   "metres at which occluders cease to count; nearer ones count by a smooth fall-off (default: they "
                   "count at any distance)")
        ->check(aboveZero());
    CLI::Option* local =
        app.add_flag("--local", command.local,
                     "also bake the moments that nearby parts of the mesh alone leave visible (/visibility/local)");
    app.add_option("--local-steps", command.local_moments.steps, "how many bones away a part still counts as nearby")
        ->check(within(1, kMaxLocalSteps, "bones with a part"))
        ->needs(local);
    app.add_option("--local-order", command.local_moments.order, "SH bands of the local moments")
        ->check(within(kMinLocalOrder, kMaxLocalOrder, "bands"))
        ->needs(local);
    addChoice(app, "--quantity", command.of_transfer, kQuantityWords,
              "visibility, or transfer: cosine-weighted visibility, and light that bounces");
    CLI::Option* bounces =
        app.add_option("--bounces", command.transfer.bounces, "with transfer: how often light is reflected")
            ->check(within(0, kMaxBounces, "reflections"));
    command.transfer_options = {
        bounces,
        addParsed(app, "--albedo", command.transfer.albedo, readColorChoice,
                  "with transfer and bounces: what the surface reflects, R/G/B (linear, below 1) or FILE.csv of slots "
                  "or vertices (default: the rig's base colours and textures)")
            ->needs(bounces),
        addParsed(app, "--transmission", command.transfer.transmission, readColorChoice,
                  "with transfer, bounces and --two-sided: what comes through the sheet, in the forms of --albedo")
            ->needs(bounces)};
    app.add_flag("--two-sided", options.two_sided, "a thin sheet: every vertex has a back with moments of its own")
        ->excludes(app.get_option("--one-sided"));
    app.add_option("--occluder", command.options.occluders,
                   "mesh that blocks rays and has no moments, still or animated; any number of them; MESH:CACHE where "
                   "what moves it is in a file of its own")
        ->allow_extra_args(false);
    addFile(app, "--inputs", options.inputs,
            "FILE.csv of numbers that join the pose: columns frame or time, and NAME or NAME.x, NAME.y, NAME.z");
}

}  // namespace

Verb visibilityVerb() {
    return verbOf<VisibilityCommand>("visibility", "Ray-trace per-vertex SH visibility over an animation.",
                                     defineVisibility, runVisibility);
}

}  // namespace penumbra
