// penumbra-bake visibility RIG... -o X.vis.h5: ray-traced visibility of every vertex over an animation.
#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "bake/bake_verbs.h"
#include "bake/source/frame_choice.h"
#include "bake/source/surface_colors.h"
#include "bake/visibility/bake_estimate.h"
#include "formats/cache/numbered_files.h"
#include "formats/common/errors.h"
#include "formats/common/name_list_option.h"
#include "formats/common/warning.h"

namespace penumbra {

namespace {

double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024e-6;  // Linux counts in KiB
}

struct VisibilityCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, known after reading
    std::filesystem::path output;
    BakeOptions options;
    std::string frames, poses, inputs, ground, precision = "f32", units = "m", up = "y";
    const CLI::Option* ground_option = nullptr;
    bool local = false;
    LocalMoments local_moments;
    std::vector<const CLI::Option*> local_options;  // those that go with --local
    std::string quantity = "visibility", albedo, transmission;
    TransferOptions transfer;
    std::vector<const CLI::Option*> transfer_options;  // those that go with --quantity transfer
    bool resume = false;
    std::int64_t seed = std::int64_t(BakeOptions{}.seed);  // signed, so that -1 is refused instead of wrapping around
};

// Reads `--ground`, which stands alone or has a height.
void readGround(VisibilityCommand& command) {
    BakeOptions& options = command.options;
    options.ground = command.ground_option->count() > 0;
    if (!options.ground || command.ground == "rest") return;
    double height = 0;
    const char* end = command.ground.data() + command.ground.size();
    const auto [stop, error] = std::from_chars(command.ground.data(), end, height);
    if (error != std::errc() || stop != end || !std::isfinite(float(height)))
        throw UsageError("--ground takes a height in metres, rest or nothing, not '" + command.ground +
                         "'; put it behind the files where it has no height");
    options.ground_y = height;
}

void readLocal(VisibilityCommand& command) {
    if (command.local) command.options.local = command.local_moments;
    for (const CLI::Option* option : command.local_options)
        if (!command.local && option->count() > 0) throw UsageError(option->get_name() + " goes with --local");
}

void readTransfer(VisibilityCommand& command) {
    const bool transfer = command.quantity == "transfer";
    for (const CLI::Option* option : command.transfer_options)
        if (!transfer && option->count() > 0) throw UsageError(option->get_name() + " goes with --quantity transfer");
    if (!transfer) return;
    command.transfer.albedo = readColorChoice(command.albedo);
    command.transfer.transmission = readColorChoice(command.transmission);
    command.options.transfer = command.transfer;
}

std::string asJson(const std::vector<std::string>& names) {
    return nlohmann::ordered_json(names).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void reportPlan(const BakePlan& plan, const BakeOptions& options, Report& report) {
    report.figures["frames"] = plan.header.frames.frameCount();
    report.figures["vertices"] = plan.header.mesh.vertexCount();
    report.figures["triangles"] = plan.header.mesh.triangles.size();
    report.figures["rays"] = plan.rays();
    report.figures["uncompressed_bytes"] = plan.bytes(options.precision);
    if (!plan.albedo_from.empty()) report.figures["albedo_from"] = plan.albedo_from;
}

// Prints what the readers of point caches noted.
void reportNotes(const BakePlan& plan) {
    std::vector<const BakeSource*> sources = {&plan.source};
    for (const Occluder& occluder : plan.occluders) sources.push_back(&occluder.source);
    for (const BakeSource* source : sources)
        if (source->cache)
            for (const std::string& note : source->cache->notes) reportWarning("penumbra-bake", note);
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
    BakeOptions& options = command.options;
    if (!command.frames.empty()) options.frames = parseFrameRange(command.frames);
    if (!command.poses.empty()) options.poses = command.poses;
    if (command.seed < 0)
        throw UsageError("--seed must be 0..9223372036854775807, not " + std::to_string(command.seed));
    options.seed = std::uint64_t(command.seed);
    refuseTwice(command.rigs);
    options.cache.metres = metresOfUnit(command.units);
    options.cache.z_up = upIsZ(command.up);
    readGround(command);
    readLocal(command);
    readTransfer(command);
    if (!command.inputs.empty()) options.inputs = command.inputs;
    options.precision = command.precision == "f16" ? Precision::kFloat16 : Precision::kFloat32;
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
    const ProgressStyle style = parseProgressStyle(common.quiet ? "none" : common.progress);

    report.phase("read");
    const BakePlan plan = planBake(command.rigs, options);
    command.files_read = plan.files_read;
    reportNotes(plan);
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
    if (std::string damage; command.resume && isWhole(command.output, plan, damage)) {
        report.figures["already_whole"] = true;
        if (!common.quiet) std::printf("%s: is this bake already, and whole\n", command.output.c_str());
        return;
    } else if (!damage.empty() && !common.quiet) {
        reportWarning("penumbra-bake", damage + ": all of it is baked anew");
    }
    report.phase("trace and write");
    const BakeResult result = bakeVisibility(plan, options, {command.output, command.resume}, common.threads, style);
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
    app.add_option("--fps", options.fps, "samples a second (default: the clips' own keys)");
    app.add_option("--frames", command.frames, "A:B[:S], half-open, of the sampled frames of all chosen clips");
    app.add_option("--blocks", options.blocks,
                   "cut every clip into this many blocks of equal length, clips NAME#1, NAME#2, ... (to hold one out)");
    app.add_option("--units", command.units, "of a point cache: m, cm, mm, inch or metres (default: m)");
    app.add_option("--up", command.up, "of a point cache: y or z (default: y)");
    app.add_option("--cache-fps", options.cache.fps,
                   "keys a second of a point cache (default: as its file says, else 24)");
    app.add_option("--poses", command.poses,
                   "X.poses.h5 of `penumbra-bake poses`: these frames, then those of --clips");
    app.add_option("--order", options.order, "SH bands, 1..8");
    app.add_option("--rays", options.rays, "directions above the horizon");
    app.add_option("--seed", command.seed, "turns the set of directions");
    app.add_option("--bias", options.bias, "start of a ray above the surface, in rest diagonals");
    app.add_option("--precision", command.precision, "of the coefficients on disk")
        ->check(CLI::IsMember({"f32", "f16"}));
    app.add_flag("--resume", command.resume,
                 "go on where a killed bake of this output stopped; keep what is done when stopped");
    command.ground_option =
        app.add_option("--ground", command.ground,
                       "an infinite floor blocks every direction that points down; its height, or rest: the "
                       "lowest point at rest")
            ->expected(0, 1)
            ->default_str("rest")
            ->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    app.add_flag("--local", command.local,
                 "also bake the moments that nearby parts of the mesh alone leave visible (/visibility/local)");
    command.local_options = {
        app.add_option("--local-steps", command.local_moments.steps, "of --local: how many bones away is near, 1..8"),
        app.add_option("--local-order", command.local_moments.order, "of --local: SH bands, 5 or 6")};
    app.add_option("--quantity", command.quantity,
                   "visibility, or transfer: cosine-weighted visibility, and light that bounces")
        ->check(CLI::IsMember({"visibility", "transfer"}));
    command.transfer_options = {
        app.add_option("--bounces", command.transfer.bounces, "of transfer: how often light is reflected, 0..16"),
        app.add_option("--albedo", command.albedo,
                       "of transfer with bounces: what the surface reflects, R/G/B (linear, below 1) or FILE.csv of "
                       "slots or vertices (default: the rig's base colours and textures)"),
        app.add_option("--transmission", command.transmission,
                       "of transfer with bounces and --two-sided: what comes through the sheet, as --albedo")};
    app.add_flag("--two-sided", options.two_sided, "a thin sheet: every vertex has a back with moments of its own");
    app.add_option("--occluder", command.options.occluders,
                   "mesh that blocks rays and has no moments, still or animated; any number of them; MESH:CACHE where "
                   "what moves it is in a file of its own")
        ->allow_extra_args(false);
    app.add_option("--inputs", command.inputs,
                   "FILE.csv of numbers that join the pose: columns frame or time, and NAME or NAME.x, NAME.y, NAME.z");
}

// Returns the files that were read. Before that is known, returns those that the command names, without patterns and
// folders of numbered files.
std::vector<std::filesystem::path> inputsOf(const VisibilityCommand& command) {
    if (!command.files_read.empty()) return command.files_read;
    std::vector<std::filesystem::path> inputs = singleFilesOf(command.options.occluders);
    std::copy_if(command.rigs.begin(), command.rigs.end(), std::back_inserter(inputs),
                 [](const std::filesystem::path& rig) { return !namesSequence(rig); });
    for (const std::string& file : {command.poses, command.inputs})
        if (!file.empty()) inputs.push_back(file);
    return inputs;
}

}  // namespace

Verb visibilityVerb() {
    const auto command = std::make_shared<VisibilityCommand>();
    return {"visibility",
            "Ray-trace per-vertex SH visibility over an animation.",
            [command](CLI::App& app) { defineVisibility(app, *command); },
            [command] { return inputsOf(*command); },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runVisibility(*command, common, report); }};
}

}  // namespace penumbra
