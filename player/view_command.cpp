#include "player/view_command.h"

#include <cstdio>

#include "formats/errors.h"
#include "player/view_loop.h"
#include "player/view_scene.h"

namespace penumbra {

struct ViewCommand {
    std::vector<std::filesystem::path> assets, truths;
    ViewOptions options;
    std::string size, path = "auto", reflectance = "slices", light_form = "auto";
};

static void runViewCommand(ViewCommand& command, const CommonOptions& common, Report& report) {
    ViewOptions& options = command.options;
    RenderOptions limits;  // a window's size has a picture's
    if (!command.size.empty()) {
        parseSize(command.size, limits.width, limits.height);
        if (const std::string problem = findProblem(limits); !problem.empty()) throw UsageError(problem);
        options.size = {limits.width, limits.height};
    }
    options.path = parsePath(command.path);
    options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    options.files = command.assets;
    options.files.insert(options.files.end(), command.truths.begin(), command.truths.end());
    if (!std::filesystem::is_directory(options.screenshots))
        throw IoError(options.screenshots.string() + ": no such folder for screenshots");
    if (common.dry_run) {
        const Scene scene = openScene(options.files, common.threads);
        std::printf("would show %zu character%s, %zu materials, %zu lights\n", scene.characters.size(),
                    scene.characters.size() == 1 ? "" : "s", scene.material_names.size(), scene.light_names.size());
        return;
    }
    report.phase("view");
    const ViewResult result = runView(options, common.threads, common.quiet);
    report.figures["gl"] = result.gl;
    report.figures["path"] = result.path == EvaluationPath::kCpu ? "cpu" : "glsl";
    report.figures["frames"] = result.frames;
    if (!result.problem.empty()) std::fprintf(stderr, "penumbra-player: %s\n", result.problem.c_str());
}

static void defineView(CLI::App& app, ViewCommand& command) {
    app.add_option("assets", command.assets,
                   "X.pnb files: characters side by side; others add materials and lights, an .exr or .hdr a light")
        ->required();
    app.add_option("--truth", command.truths, "X.truth.pnb: baked frames to compare with; any number of them");
    app.add_option("--size", command.size, "WIDTHxHEIGHT of the window (default: as it was left, else 1280x800)");
    app.add_flag("!--no-settings", command.options.settings, "neither read nor keep what the window was left with");
    app.add_option("--path", command.path, "where vertices are evaluated: auto, cpu or glsl")->capture_default_str();
    app.add_option("--light-form", command.light_form,
                   "as in render: auto (= rotation), lobes, fixed or rotation; V in the window")
        ->capture_default_str();
    app.add_option("--reflectance", command.reflectance, "as in render: slices or operators; P in the window")
        ->capture_default_str();
    app.add_option("--screenshots", command.options.screenshots, "folder that F12 writes view_0001.png, ... into")
        ->capture_default_str();
}

Verb viewVerb() {
    const auto command = std::make_shared<ViewCommand>();
    return {"view",
            "Show assets in a window (F1 lists the keys).",
            [command](CLI::App& app) { defineView(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs = command->assets;
                inputs.insert(inputs.end(), command->truths.begin(), command->truths.end());
                return inputs;
            },
            [] { return std::filesystem::path(); },
            [command](const CommonOptions& common, Report& report) { runViewCommand(*command, common, report); }};
}

}  // namespace penumbra
