#include "player/render_flags.h"

#include "formats/common/errors.h"
#include "formats/image/tone_map.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/unused_flags.h"

namespace penumbra {

void defineRender(CLI::App& app, RenderCommand& command) {
    command.app = &app;
    CLI::Option* assets =
        app.add_option("assets", command.assets,
                       "X.pnb with a model; several stand side by side on a ground, and cast on one another");
    app.add_option("-o,--output", command.output,
                   "OUT.png or OUT.exr (half floats, colours times coverage); the files of a sequence have %d or %0Nd "
                   "in their name, as out.%04d.png")
        ->required();
    CLI::Option* scene =
        app.add_option("--scene", command.scene,
                       "S.json instead of assets: characters on a ground that cast on one another (docs/scene.md)")
            ->excludes(assets);
    app.add_option("--truth", command.truth,
                   "X.truth.pnb: baked frames, for errors, --channel error and --source truth");
    addLookFlags(app, command.options);
    addChoice(
        app, "--tone", command.options.tone, kToneWords,
        "curve of a shaded PNG, off, reinhard or filmic: what is brighter than white is cut, or bent as the window "
        "does it (default: off)")
        ->group(kLookGroup);
    addPictureFlags(app, command.options);
    addChoice(app, "--source", command.options.source, kSourceWords, "visibility of the model or of the truth")
        ->group(kPictureGroup);
    addOverlayFlags(app, command.options);
    addFramesFlags(app, command.frames);
    addTimeFlag(app, command.time);
    addCastFlags(app, command.cast);
    app.add_option("--compare", command.compared,
                   "REF.exr of penumbra-bake reference --scene, of the same size, to print FLIP and RMSE against")
        ->type_name("FILE")
        ->group(kSceneGroup);
    // The scene itself says these.
    for (const char* option : {"--brdf", "--light", "--light-rotation"}) scene->excludes(app.get_option(option));
}

std::vector<std::filesystem::path> RenderCommand::inputs() const {
    std::vector<std::filesystem::path> files = assets;
    files.insert(files.end(), {scene, truth, compared});
    return namedFiles(files);
}

namespace {

void checkFrames(RenderCommand& command) {
    FrameChoice& choice = command.frames.choice;
    const bool pattern = FramePattern::looksLikeOne(command.output);
    const bool many_clips = choice.clips.size() > 1 || choice.clips == std::vector<std::string>{"all"};
    choice.sequence = !choice.frame && (choice.frames || many_clips || pattern);
    const std::string problem = endsIn({".png", ".exr"})(command.output.string());
    if (!problem.empty()) throw BadOption("output", problem);
    if (choice.sequence || pattern) FramePattern check(command.output);
}

// Refuses what would give another result than asked for.
void refuseWrong(const RenderCommand& command) {
    const Channel channel = command.options.channel;
    const std::string in_channel = "--channel " + std::string(nameOf(channel));
    if (command.isScene() && channel != Channel::kShaded && channel != Channel::kAmbient && channel != Channel::kError)
        throw UsageError(in_channel + ": a scene is drawn as shaded, ao or error");
    if (command.isScene() && channel == Channel::kError && command.truth.empty())
        throw UsageError(in_channel + " needs --truth X.truth.pnb (penumbra-pack truth makes it)");
    if (!command.compared.empty() && channel != Channel::kShaded) throw UsageError("--compare needs --channel shaded");
    for (const CLI::Option* option : command.app->get_options()) {
        if (option->count() == 0) continue;
        const std::string name = option->get_name(), group = option->get_group();
        const bool of_one = group == kFramesGroup || group == kOverlayGroup || name == "--slot" ||
                            name == "--parameter" || name == "--source";
        if (command.isScene() && of_one) throw UsageError(name + " is for one asset, not for a scene");
        if (!command.isScene() && group == kSceneGroup) throw UsageError(name + " is for scenes, not for one asset");
        if (group == kOverlayGroup && channel == Channel::kNormals)
            throw UsageError(name + " is not drawn in --channel normals");
    }
}

// Says where an option changes nothing, or "".
std::string unusedWhere(const RenderCommand& command, const CLI::Option& option) {
    const RenderOptions& options = command.options;
    const std::string& name = option.get_name();
    const std::string in_channel = "in --channel " + std::string(nameOf(options.channel));
    if (option.get_group() == kLookGroup && options.channel != Channel::kShaded) return in_channel;
    if (name == "--error-max" && !needsTruth(options.channel)) return in_channel;
    if (name == "--truth" && !command.frames.choice.sequence && !needsTruth(options.channel) &&
        options.source != VisibilitySource::kTruth)
        return "without a sequence, --channel error or transfer-error, or --source truth";
    return {};
}

}  // namespace

void checkRender(RenderCommand& command) {
    if (command.assets.empty() && command.scene.empty())
        throw UsageError("an asset, X.pnb, or a --scene S.json is required");
    checkFrames(command);
    refuseWrong(command);
    warnOfUnused(*command.app, [&command](const CLI::Option& option) { return unusedWhere(command, option); });
}

}  // namespace penumbra
