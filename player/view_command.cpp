// penumbra-player view X.pnb...: assets in a window.
#include <cstdio>

#include "formats/common/errors.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/player_verbs.h"
#include "player/view/view_scene.h"
#include "player/view/window/view_loop.h"
#include "player/view/window_place.h"

namespace penumbra {

namespace {

struct ViewCommand {
    std::vector<std::filesystem::path> assets, truths;
    std::filesystem::path scene;
    ViewOptions options;
    bool no_settings = false;

    std::vector<std::filesystem::path> inputs() const {
        std::vector<std::filesystem::path> files = assets;
        files.insert(files.end(), truths.begin(), truths.end());
        files.push_back(scene);
        return namedFiles(files);
    }
};

std::pair<int, int> parseWindowSize(const std::string& text) {
    const std::optional<PictureSize> size = parseSize(text);
    if (!size || size->width < kMinWidth || size->width > kMaxWidth || size->height < kMinHeight ||
        size->height > kMaxHeight)
        throw std::invalid_argument("must be from " + std::to_string(kMinWidth) + "x" + std::to_string(kMinHeight) +
                                    " to " + std::to_string(kMaxWidth) + "x" + std::to_string(kMaxHeight) + ", not " +
                                    text);
    return {size->width, size->height};
}

void runViewCommand(ViewCommand& command, const CommonOptions& common, Report& report) {
    ViewOptions& options = command.options;
    options.settings = !command.no_settings;
    options.quiet = common.quiet;
    options.files = command.assets;
    if (!command.scene.empty()) options.files.insert(options.files.begin(), command.scene);
    if (options.files.empty()) throw UsageError("name an asset, or a scene with --scene");
    options.files.insert(options.files.end(), command.truths.begin(), command.truths.end());
    if (!std::filesystem::is_directory(options.screenshots))
        throw IoError(options.screenshots.string() + ": no such folder for screenshots");
    if (common.dry_run) {
        const Scene scene = openScene(options.files, common.threads);
        ViewState state = stateFor(scene, {});
        applySceneFile(scene, state);
        std::printf("would show %zu character%s, %zu materials, %zu lights\n", scene.characters.size(),
                    scene.characters.size() == 1 ? "" : "s", scene.material_names.size(), scene.light_names.size());
        return;
    }
    for (const std::filesystem::path& file : options.files)
        if (file.extension() == ".json") report.willRead(filesNamedIn(readScene(file)));
    report.phase("view");
    const ViewResult result = runView(options, common.threads);
    report.figures["gl"] = result.gl;
    report.figures["path"] = result.path == EvaluationPath::kCpu ? "cpu" : "glsl";
    report.figures["frames"] = result.frames;
    if (!result.problem.empty()) std::fprintf(stderr, "penumbra-player: %s\n", result.problem.c_str());
}

void defineView(CLI::App& app, ViewCommand& command) {
    app.add_option("assets", command.assets,
                   "X.pnb files: characters side by side; others add materials and lights, an .exr or .hdr a light");
    app.add_option("--scene", command.scene,
                   "scene.json: who stands where (docs/scene.md), also on ground with heights, which key 0's brush "
                   "shapes (docs/heightfield.md)")
        ->check(endsIn({".json"}));
    app.add_option("--truth", command.truths, "X.truth.pnb: baked frames to compare with; any number of them");
    addParsed(app, "--size", command.options.size, parseWindowSize,
              "WIDTHxHEIGHT of the window (default: as it was left, else 1280x800)");
    app.add_flag("--no-settings", command.no_settings, "neither read nor keep what the window was left with");
    addPathFlag(app, command.options.path);
    addShadingFlags(app, command.options.shading);
    app.add_option("--light-fade", command.options.fade.seconds,
                   "seconds in which one light becomes the next; 0: at once")
        ->check(within(0.0, 60.0));
    app.add_option("--sun-time", command.options.fade.sun_time,
                   "time constant in seconds of the suns that are found while lights change; 0: not smoothed")
        ->check(within(0.0, 10.0));
    app.add_option("--screenshots", command.options.screenshots, "folder that F12 writes view_0001.png, ... into");
}

}  // namespace

Verb viewVerb() {
    return verbOf<ViewCommand>("view", "Show assets in a window (F1 lists the keys).", defineView, runViewCommand);
}

}  // namespace penumbra
