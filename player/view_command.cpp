// penumbra-player view X.pnb...: assets in a window.
#include <cstdio>

#include "formats/capture/capture_words.h"
#include "formats/common/errors.h"
#include "formats/image/light_picture_flags.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/player_verbs.h"
#include "player/view/view_scene.h"
#include "player/view/window/live_loop.h"
#include "player/view/window/view_loop.h"
#include "player/view/window_place.h"

namespace penumbra {

namespace {

struct ViewCommand {
    std::vector<std::filesystem::path> assets, truths;
    std::filesystem::path scene;
    ViewOptions options;
    bool no_settings = false;
    LiveOptions live;
    std::optional<MirrorBall> ball;
    std::optional<Vec3d> at;
    std::optional<double> paper;

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

// Characters in photographs as they come.
void runLivePlates(ViewCommand& command, const CommonOptions& common, Report& report) {
    LiveOptions& live = command.live;
    if (command.scene.empty()) throw UsageError("--plate: needs --scene, which has the camera and the characters");
    if (!command.assets.empty() || !command.truths.empty())
        throw UsageError("--plate: shows what --scene names, and no other assets");
    if (command.ball.has_value() != command.at.has_value()) throw UsageError("--ball and --at: give both, or neither");
    if (command.paper && live.tags.empty()) throw UsageError("--paper: needs --tag, whose paper it is");
    live.scene = command.scene;
    live.size = command.options.size;
    live.screenshots = command.options.screenshots;
    live.look.shading = command.options.shading;
    live.look.textures = command.options.textures;
    if (command.ball) {
        live.ball = LiveBall{*command.ball, *command.at, {}, command.paper.value_or(1)};
        if (command.paper) live.ball->paper = live.tags.front();
    }
    report.willRead(filesNamedIn(readScene(command.scene)));
    if (common.dry_run) {
        std::printf("would show %s in the photographs of %s\n", live.scene.c_str(), live.plate.c_str());
        return;
    }
    report.phase("view");
    const LiveResult result = runLive(live, common.threads);
    report.figures = {{"gl", result.gl},          {"pictures", result.pictures},  {"with_tags", result.seen},
                      {"track_ms", result.track}, {"compose_ms", result.compose}, {"latency_ms", result.latency}};
    if (!common.quiet)
        std::printf(
            "%zu pictures, %zu with a tag: %.1f ms a picture for tags, %.1f ms for the composite, %.1f ms until it is "
            "shown\n",
            result.pictures, result.seen, result.track, result.compose, result.latency);
}

void runViewCommand(ViewCommand& command, const CommonOptions& common, Report& report) {
    if (!command.live.plate.empty()) return runLivePlates(command, common, report);
    ViewOptions& options = command.options;
    options.settings = !command.no_settings;
    options.quiet = common.quiet;
    options.files = command.assets;
    if (!command.scene.empty()) options.files.insert(options.files.begin(), command.scene);
    if (options.files.empty() && (common.dry_run || !command.truths.empty()))
        throw UsageError("name an asset, or a scene with --scene");
    options.files.insert(options.files.end(), command.truths.begin(), command.truths.end());
    if (!std::filesystem::is_directory(options.screenshots))
        throw IoError(options.screenshots.string() + ": no such folder for screenshots");
    if (common.dry_run) {
        const Scene scene = openScene(options.files, common.threads, {options.reading, options.textures, {}});
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

void definePlates(CLI::App& app, ViewCommand& command) {
    constexpr const char* kGroup = "Characters in photographs as they come (docs/ar.md)";
    LiveOptions& live = command.live;
    CLI::Option* plate = app.add_option("--plate", live.plate,
                                        "a folder of photographs, P.%03d.jpg, P.y4m, - for a .y4m on standard input, "
                                        "or a camera as /dev/video0; --scene has the camera and the characters")
                             ->group(kGroup);
    addTagOption(app, live.tags, "FAMILY:ID:SIDE of printed tags that show where the camera stands")
        ->needs(plate)
        ->group(kGroup);
    app.add_option("--response", live.response,
                   "response of the camera: srgb, linear, rec709, or a file of penumbra-fit response")
        ->needs(plate)
        ->group(kGroup);
    app.add_option("--exposure", live.exposure,
                   "exposure of the photographs: light of 1 times this has the highest code")
        ->check(aboveZero())
        ->needs(plate)
        ->group(kGroup);
    addParsed(app, "--ball", command.ball, parseBall,
              "x/y/z,radius[,reflectance] of a mirror ball, metres of the marker's frame, whose light replaces that of "
              "the scene while it is seen")
        ->needs(plate)
        ->group(kGroup);
    addParsed(app, "--at", command.at, parsePlace, "x/y/z where that light is wanted: the middle of the character")
        ->needs(plate)
        ->group(kGroup);
    app.add_option(
           "--paper", command.paper,
           "reflectance of the tag's paper: what is clipped in the ball is raised until the paper has its light")
        ->check(within(0.01, 1.0))
        ->needs(plate)
        ->group(kGroup);
    app.add_option("--pictures", live.pictures, "end after so many photographs")->needs(plate)->group(kGroup);
}

void defineView(CLI::App& app, ViewCommand& command) {
    app.add_option("assets", command.assets,
                   "X.pnb files: characters side by side; others add materials and lights, an .exr or .hdr a light; "
                   "without any the window lists files to open");
    app.add_option("--scene", command.scene,
                   "scene.json: who stands where (docs/scene.md), also on ground with heights, which key 0's brush "
                   "shapes (docs/heightfield.md)")
        ->check(endsIn({".json"}));
    app.add_option("--truth", command.truths, "X.truth.pnb: baked frames to compare with; any number of them");
    addParsed(app, "--size", command.options.size, parseWindowSize,
              "WIDTHxHEIGHT of the window (default: as it was left, else 1280x800)");
    app.add_flag("--no-settings", command.no_settings, "do not read or keep the settings of the window");
    addPathFlag(app, command.options.path);
    addShadingFlags(app, command.options.shading);
    addTextureFlag(app, command.options.textures);
    app.add_option("--light-fade", command.options.fade.seconds,
                   "seconds in which one light becomes the next; 0: at once")
        ->check(within(0.0, 60.0));
    app.add_option("--sun-time", command.options.fade.sun_time,
                   "time constant in seconds of the suns that are found while lights change; 0: not smoothed")
        ->check(within(0.0, 10.0));
    app.add_option("--screenshots", command.options.screenshots, "folder that F12 writes view_0001.png, ... into");
    addLightPictureOptions(app, command.options.reading);
    definePlates(app, command);
}

}  // namespace

Verb viewVerb() {
    return verbOf<ViewCommand>("view", "Show assets in a window (F1 lists the keys).", defineView, runViewCommand);
}

}  // namespace penumbra
