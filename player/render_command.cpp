#include "player/render_command.h"

#include <cmath>
#include <cstdio>

#include "formats/errors.h"
#include "player/open_asset.h"
#include "player/render_offscreen.h"

namespace penumbra {

struct RenderCommand {
    std::filesystem::path asset, truth, output;
    RenderOptions options;
    std::string size, channel = "shaded", source = "model", path = "auto", backend = "auto", background = "transparent";
    std::string reflectance = "slices", light_form = "auto";
    std::vector<const CLI::Option*> shading;  // what only --channel shaded reads
    const CLI::Option *truth_option = nullptr, *error_max_option = nullptr;
};

static void parseWords(RenderCommand& command) {
    RenderOptions& options = command.options;
    if (!command.size.empty()) parseSize(command.size, options.width, options.height);
    options.channel = parseChannel(command.channel);
    options.source = parseSource(command.source);
    options.path = parsePath(command.path);
    options.backend = parseGlBackend(command.backend);
    options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    options.background = parseBackground(command.background);
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
    const std::string extension = command.output.extension();
    if (extension != ".png" && extension != ".exr")
        throw UsageError(command.output.string() + ": a picture must be named .png or .exr");
}

static void refuseUnused(const RenderCommand& command) {
    const Channel channel = command.options.channel;
    for (const CLI::Option* option : command.shading)
        if (option->count() > 0 && channel != Channel::kShaded)
            throw UsageError(option->get_name() + " is of no use to --channel " + command.channel);
    if (command.error_max_option->count() > 0 && channel != Channel::kError)
        throw UsageError("--error-max is of no use to --channel " + command.channel);
    if (command.truth_option->count() > 0 && channel != Channel::kError &&
        command.options.source != VisibilitySource::kTruth)
        throw UsageError("--truth is of no use without --channel error or --source truth");
}

// Normals are numbers, so that a PNG's 8-bit value / 255 must give them back: the inverse of the transfer function that
// writePng() applies, on colours that it then divides by alpha.
static Image normalsForPng(Image image) {
    const auto linear = [](float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); };
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = image.alpha.empty() ? 1 : image.alpha[i];
        if (alpha == 0) continue;
        for (int c = 0; c < 3; ++c) image.pixels[i][c] = alpha * linear(image.pixels[i][c] / alpha);
    }
    return image;
}

static void reportResult(const RenderResult& result, const RenderOptions& options, const CommonOptions& common,
                         Report& report) {
    const char* path = result.path == EvaluationPath::kCpu ? "cpu" : "glsl";
    report.figures["width"] = options.width;
    report.figures["height"] = options.height;
    report.figures["gl"] = result.gl;
    report.figures["path"] = path;
    report.figures["out_of_range"] = result.out_of_range;
    if (!common.quiet)
        std::printf(
            "out of range by %.4f: how far the pose has what hides the sky from where training frames had it, "
            "about radians\n",
            result.out_of_range);
    if (common.verbosity > 0) std::printf("%s; path %s\n", result.gl.c_str(), path);
    if (!result.ambient_error) return;
    report.figures["ambient_error_mean"] = result.ambient_error->mean;
    report.figures["ambient_error_max"] = result.ambient_error->max;
    if (!common.quiet)
        std::printf("ambient error |E(%s) - E(truth)| over all vertices: mean %.5f, max %.5f; colours: 0 to %g\n",
                    options.source == VisibilitySource::kModel ? "model" : "truth", result.ambient_error->mean,
                    result.ambient_error->max, double(options.error_max));
}

static void runRender(RenderCommand& command, const CommonOptions& common, Report& report) {
    parseWords(command);
    refuseUnused(command);
    report.phase("read");
    const OpenAsset asset(command.asset);
    std::optional<OpenAsset> truth;
    if (!command.truth.empty()) truth.emplace(command.truth);
    const AssetView* truth_view = truth ? &truth->view : nullptr;
    if (common.dry_run) {
        const Shot shot = resolveShot(command.options, asset.view, truth_view);
        std::printf("would draw frame %zu of %zu, %d x %d pixels, to %s\n", shot.frame,
                    asset.view.animation.frameCount(), command.options.width, command.options.height,
                    command.output.c_str());
        return;
    }
    report.phase("draw");
    RenderResult result = renderOffscreen(command.options, asset.view, truth_view, common.threads);
    report.phase("write");
    if (command.options.channel == Channel::kNormals && command.output.extension() == ".png")
        result.image = normalsForPng(std::move(result.image));
    writeImage(command.output, result.image,
               command.options.channel == Channel::kShaded ? command.options.exposure : 1);
    reportResult(result, command.options, common, report);
    if (command.options.channel == Channel::kShaded) {
        report.figures["reflectance"] = command.reflectance;
        report.figures["light_form"] = nameOf(command.options.shading.light_form);
    }
}

static void defineRender(CLI::App& app, RenderCommand& command) {
    RenderOptions& options = command.options;
    app.add_option("asset", command.asset, "X.pnb with a model")->required();
    app.add_option("-o,--output", command.output, "OUT.png or OUT.exr (half floats, colours times coverage)")
        ->required();
    app.add_option("--clip", options.clip, "name of the clip, or how only it begins (default: the first)");
    app.add_option("--frame", options.frame, "sampled frame of the clip, from 0")->capture_default_str();
    command.shading = {
        app.add_option(
            "--brdf", options.brdf,
            "name of one material for all parts, or how only it begins (default: what the asset gives each)"),
        app.add_option(
            "--slot", options.slots,
            "SLOT=NAME: the material of a part of the mesh (penumbra-bake info lists the slots); any number of them"),
        app.add_option("--light", options.light, "name of the light, or how only it begins (default: the first)"),
        app.add_option("--light-rotation", options.light_rotation,
                       "yaw=,pitch=,roll= or axis=X/Y/Z,angle= (degrees) that the light is turned by"),
        app.add_option("--light-form", command.light_form,
                       "how the light is turned into each vertex' frame: auto, lobes (as fitted), fixed or rotation "
                       "(both exact)")
            ->capture_default_str(),
        app.add_option("--reflectance", command.reflectance,
                       "what a material is evaluated from: slices, or the paper's operators")
            ->capture_default_str(),
        app.add_option("--exposure", options.exposure, "factor on the colours of a shaded PNG")->capture_default_str()};
    app.add_option("--size", command.size, "WIDTHxHEIGHT in pixels (default: 512x512)");
    app.add_option("--camera", options.camera,
                   "yaw=,pitch=,fov= (degrees), distance=,target=X/Y/Z; what is not given is framed");
    app.add_option("--channel", command.channel, "shaded, ao, error, clusters or normals")->capture_default_str();
    command.truth_option =
        app.add_option("--truth", command.truth, "X.truth.pnb: baked frames, for --channel error and --source truth");
    app.add_option("--source", command.source, "visibility of the model or of the truth")->capture_default_str();
    app.add_option("--path", command.path, "where vertices are evaluated: auto, cpu or glsl")->capture_default_str();
    app.add_option("--gl", command.backend, "auto (a GPU, else software), egl or osmesa")->capture_default_str();
    app.add_option("--background", command.background, "transparent or R/G/B, linear")->capture_default_str();
    app.add_option("--aa", options.samples, "samples a pixel: 1, 2, 4 or 8")->capture_default_str();
    command.error_max_option =
        app.add_option("--error-max", options.error_max, "the error that gets the brightest colour of --channel error")
            ->capture_default_str();
}

Verb renderVerb() {
    const auto command = std::make_shared<RenderCommand>();
    return {"render",
            "Draw one frame of an asset, without a window.",
            [command](CLI::App& app) { defineRender(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs = {command->asset};
                if (!command->truth.empty()) inputs.push_back(command->truth);
                return inputs;
            },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runRender(*command, common, report); }};
}

}  // namespace penumbra
