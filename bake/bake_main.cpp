// penumbra-bake: ray-traced visibility over an animation, and ray-traced pictures to hold results against.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bake/bake_reference.h"
#include "bake/bake_visibility.h"
#include "bake/frame_choice.h"
#include "bake/info_command.h"
#include "bake/poses_command.h"
#include "formats/brdf_source.h"
#include "formats/command_line.h"
#include "formats/errors.h"
#include "formats/name_list_option.h"
#include "sh/sh_basis.h"

namespace penumbra {

static double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024e-6;  // Linux counts in KiB
}

struct VisibilityCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, once that is known
    std::filesystem::path output;
    BakeOptions options;
    std::string frames, poses, precision = "f32";
    std::int64_t seed = std::int64_t(BakeOptions{}.seed);  // signed, so that -1 is refused and does not wrap
};

static void reportPlan(const BakePlan& plan, const BakeOptions& options, Report& report) {
    report.figures["frames"] = plan.header.frames.frameCount();
    report.figures["vertices"] = plan.header.mesh.vertexCount();
    report.figures["triangles"] = plan.header.mesh.triangles.size();
    report.figures["rays"] = plan.rays();
    report.figures["uncompressed_bytes"] = plan.bytes(options.precision);
}

static void runVisibility(VisibilityCommand& command, const CommonOptions& common, Report& report) {
    BakeOptions& options = command.options;
    if (!command.frames.empty()) options.frames = parseFrameRange(command.frames);
    if (!command.poses.empty()) options.poses = command.poses;
    if (command.seed < 0)
        throw UsageError("--seed must be 0..9223372036854775807, not " + std::to_string(command.seed));
    options.seed = std::uint64_t(command.seed);
    refuseTwice(command.rigs);
    options.precision = command.precision == "f16" ? Precision::kFloat16 : Precision::kFloat32;
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
    const ProgressStyle style = parseProgressStyle(common.quiet ? "none" : common.progress);

    report.phase("read");
    const BakePlan plan = planBake(command.rigs, options);
    command.files_read = plan.rig.files_read;
    reportPlan(plan, options, report);
    if (common.dry_run) {
        std::printf("%zu frames x %zu vertices x %d rays = %.1f Mray; %.1f MB before compression\n",
                    plan.header.frames.frameCount(), plan.header.mesh.vertexCount(), options.rays, plan.rays() * 1e-6,
                    plan.bytes(options.precision) * 1e-6);
        return;
    }
    report.phase("trace and write");
    const BakeResult result = bakeVisibility(plan, options, command.output, common.threads, style);
    const double rate = result.rays_traced / result.seconds;
    report.figures["rays_traced"] = result.rays_traced;
    report.figures["rays_per_second"] = rate;
    report.figures["bytes"] = result.written_bytes;
    report.figures["peak_rss_megabytes"] = peakMegabytes();
    if (!common.quiet)
        std::printf("%s: %zu frames x %zu vertices, %.1f Mray in %.1f s (%.2f Mray/s), %.1f MB, peak memory %.0f MB\n",
                    command.output.c_str(), plan.header.frames.frameCount(), plan.header.mesh.vertexCount(),
                    result.rays_traced * 1e-6, result.seconds, rate * 1e-6, result.written_bytes * 1e-6,
                    peakMegabytes());
}

static void defineVisibility(CLI::App& app, VisibilityCommand& command) {
    BakeOptions& options = command.options;
    app.add_option("rig", command.rigs, "rig; further files may bring clips only")->required();
    app.add_option("-o,--output", command.output, "X.vis.h5")->required();
    addNameListOption(app, "--clips", options.clips, "names of the clips to bake (default: all)");
    app.add_option("--fps", options.fps, "samples a second (default: the clips' own keys)");
    app.add_option("--frames", command.frames, "A:B[:S], half-open, of the sampled frames of all chosen clips");
    app.add_option("--poses", command.poses,
                   "X.poses.h5 of `penumbra-bake poses`: these frames, then those of --clips");
    app.add_option("--order", options.order, "SH bands, 1..8");
    app.add_option("--rays", options.rays, "directions above the horizon");
    app.add_option("--seed", command.seed, "turns the set of directions");
    app.add_option("--bias", options.bias, "start of a ray above the surface, in rest diagonals");
    app.add_option("--precision", command.precision, "of the coefficients on disk")
        ->check(CLI::IsMember({"f32", "f16"}));
    app.add_flag("--ground", options.ground, "an infinite floor blocks every direction that points down");
}

static Verb visibilityVerb() {
    const auto command = std::make_shared<VisibilityCommand>();
    return {"visibility",
            "Ray-trace per-vertex SH visibility over an animation.",
            [command](CLI::App& app) { defineVisibility(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs =
                    command->files_read.empty() ? command->rigs : command->files_read;
                if (command->files_read.empty() && !command->poses.empty()) inputs.push_back(command->poses);
                return inputs;
            },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runVisibility(*command, common, report); }};
}

// --- reference ------------------------------------------------------------------------------------------------------

struct ReferenceCommand {
    std::filesystem::path input, output, light, tangents;
    BrdfSource brdf;
    ReferenceOptions options;
    std::int64_t frame = 0;
    int light_order = 0;  // 0: the picture itself
    const CLI::Option* light_order_option = nullptr;
    std::string camera, size = "512x512", channel = "shaded", background = "transparent";
    float exposure = 1;
};

static Vec3 parseColor(const std::string& text) {
    Vec3 color;
    int used = 0;
    const int read = std::sscanf(text.c_str(), "%f/%f/%f%n", &color.x, &color.y, &color.z, &used);
    const float least = std::min({color.x, color.y, color.z}), sum = color.x + color.y + color.z;
    if (read != 3 || std::size_t(used) != text.size() || !(least >= 0) || !std::isfinite(sum))
        throw UsageError("--background must be transparent or R/G/B (linear, 0 or more), not '" + text + "'");
    return color;
}

static void finishOptions(ReferenceCommand& command) {
    ReferenceOptions& options = command.options;
    int used = 0;
    if (std::sscanf(command.size.c_str(), "%5dx%5d%n", &options.width, &options.height, &used) != 2 ||
        std::size_t(used) != command.size.size())
        throw UsageError("--size must be WIDTHxHEIGHT in pixels, not '" + command.size + "'");
    options.channel = command.channel == "ao"        ? ReferenceChannel::kAmbient
                      : command.channel == "normals" ? ReferenceChannel::kNormals
                                                     : ReferenceChannel::kShaded;
    if (command.background != "transparent") options.background = parseColor(command.background);
    if (command.light_order_option->count() > 0 && command.light.empty())
        throw UsageError("--light-order needs --light: the default light is the same at any order");
    if (command.light_order < 0 || command.light_order > kMaxOrder)
        throw UsageError("--light-order must be 0 (the picture itself) or 1..8, not " +
                         std::to_string(command.light_order));
    if (!(command.exposure > 0)) throw UsageError("--exposure must be above 0");
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
    const std::string extension = command.output.extension().string();
    if (extension != ".exr" && extension != ".png") throw UsageError("-o must end in .exr or .png");
}

static EnvironmentLight readLightOf(const ReferenceCommand& command) {
    if (command.light.empty()) return EnvironmentLight::white();
    EnvironmentLight light = readEnvironmentLight(command.light);
    return command.light_order > 0 ? light.bandLimited(command.light_order) : light;
}

static BrdfReading readMaterialOf(const ReferenceCommand& command, int threads) {
    BrdfSource source = command.brdf;
    source.analytic_option = "--brdf";
    if (source.analytic.empty() && source.files().empty()) source.analytic = "lambert";
    return readBrdfSource(source, threads);
}

static void runReference(ReferenceCommand& command, const CommonOptions& common, Report& report) {
    finishOptions(command);
    report.phase("read");
    const BrdfReading material = readMaterialOf(command, common.threads);
    command.options.brdfs = {material.brdf};
    report.figures["brdf"] = material.brdf.name;
    for (const auto& [name, value] : material.figures) report.figures[name] = value;
    const VisibilityReader reader(command.input);
    const VisibilityHeader& header = reader.header();
    const auto count = std::int64_t(header.frames.frameCount());
    if (command.frame < 0 || command.frame >= count)
        throw UsageError("--frame must be 0.." + std::to_string(count - 1) + ", not " + std::to_string(command.frame));
    const VisibilityFrame frame = reader.readPose(std::size_t(command.frame));
    Camera camera;
    try {
        camera = makeCamera(command.camera, frame.positions, boxDiagonal(header.mesh.rest_positions) / 2);
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--camera: ") + error.what());
    }
    const EnvironmentLight light = readLightOf(command);
    if (common.dry_run) {
        std::printf("frame %zu, %dx%d pixels, %d shadow rays a pixel\n", std::size_t(command.frame),
                    command.options.width, command.options.height, command.options.samples);
        return;
    }
    std::optional<PosedTangents> tangents;
    if (!command.tangents.empty())
        tangents = posedTangents(readModel(command.tangents), header.mesh, frame, command.tangents.string());
    report.phase("render");
    ReferenceFrame input{header.mesh, frame, header.ground_y.has_value()};
    if (tangents) input.tangents = &*tangents;
    const Image image = renderReference(input, camera, light, command.options, common.threads,
                                        parseProgressStyle(common.quiet ? "none" : common.progress));
    report.phase("write");
    const bool shaded = command.options.channel == ReferenceChannel::kShaded;
    writeImage(command.output, image, shaded ? command.exposure : 1);
}

static void defineReference(CLI::App& app, ReferenceCommand& command) {
    ReferenceOptions& options = command.options;
    app.add_option("visibility", command.input, "X.vis.h5: mesh and frames; its visibility is not used")->required();
    app.add_option("-o,--output", command.output, "REF.exr or REF.png")->required();
    app.add_option("--frame", command.frame, "index into the file's frames")->required();
    app.add_option("--brdf", command.brdf.analytic, "NAME[:key=value,...] (default: lambert)");
    app.add_option("--merl", command.brdf.merl, "measurements of the MERL database (.binary)");
    app.add_option("--table", command.brdf.table,
                   "scattered measurements (Cornell's .brdf), fits (.csv) or a Penumbra BRDF table");
    app.add_option("--material", command.brdf.material, "which row of a --table of fits");
    app.add_option("--tangents", command.tangents,
                   "X.model.h5 whose tangents anisotropic materials follow (default: a stand-in tangent)");
    app.add_option("--light", command.light, "lat-long picture (.exr, .hdr) or .light.h5 (default: white, radiance 1)");
    command.light_order_option = app.add_option("--light-order", command.light_order,
                                                "replace the picture of --light by its SH of this order (0: do not)");
    app.add_option("--camera", command.camera, "yaw=,pitch=,fov=,distance=,target=x/y/z; framed where not given");
    app.add_option("--size", command.size, "WIDTHxHEIGHT, pixels");
    app.add_option("--samples", options.samples, "shadow rays a pixel");
    app.add_option("--aa", options.camera_rays, "camera rays a pixel");
    app.add_option("--exposure", command.exposure, "factor on the colours of a shaded PNG");
    app.add_option("--background", command.background, "transparent or R/G/B (linear)");
    app.add_option("--channel", command.channel, "what to draw")->check(CLI::IsMember({"shaded", "ao", "normals"}));
}

static Verb referenceVerb() {
    const auto command = std::make_shared<ReferenceCommand>();
    return {"reference",
            "Ray-trace a picture of a baked frame: full-resolution light, true BRDF, shadow rays.",
            [command](CLI::App& app) { defineReference(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs{command->input};
                if (!command->light.empty()) inputs.push_back(command->light);
                if (!command->tangents.empty()) inputs.push_back(command->tangents);
                for (const std::filesystem::path& file : command->brdf.files()) inputs.push_back(file);
                return inputs;
            },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runReference(*command, common, report); }};
}

}  // namespace penumbra

int main(int argc, char** argv) {
    using namespace penumbra;
    return runProgram("penumbra-bake", "Ray-traced visibility of animated characters.",
                      "penumbra.visibility 1, penumbra.poses 1, penumbra.model 2, penumbra.brdf 1, penumbra.light 1, "
                      "penumbra.asset 2",
                      {visibilityVerb(), posesVerb(), referenceVerb(), infoVerb()}, argc, argv);
}
