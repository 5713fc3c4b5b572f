#include "player/render_flags.h"

#include "formats/common/warning.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"

namespace penumbra {

void defineRender(CLI::App& app, RenderCommand& command) {
    command.app = &app;
    CLI::Option* assets =
        app.add_option("assets", command.assets,
                       "X.pnb with a model; several stand side by side on a ground, and cast on one another");
    app.add_option("-o,--output", command.output,
                   "OUT.png or OUT.exr (half floats, colours times coverage); the files of a sequence have %d or %0Nd "
                   "in their name, as out.%04d.png");
    CLI::Option* scene =
        app.add_option("--scene", command.scene,
                       "S.json instead of assets: characters on a ground that cast on one another (docs/scene.md)")
            ->excludes(assets);
    CLI::Option* truth = app.add_option("--truth", command.truth,
                                        "X.truth.pnb: baked frames, for errors, --channel error and --source truth");
    addLookFlags(app, command.options);
    addPictureFlags(app, command.options);
    addOverlayFlags(app, command.options);
    addFramesFlags(app, command.frames);
    addErrorsFlags(app, command.errors, truth);
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

bool RenderCommand::draws() const { return !output.empty() || !errors.sheet.file.empty() || imageError(); }

bool RenderCommand::imageError() const {
    const bool comparable = options.channel == Channel::kShaded || options.channel == Channel::kAmbient;
    const bool asked = errors.flip || (gate && (gate->figure == Figure::kImageRmse || gate->figure == Figure::kFlip));
    return comparable && !truth.empty() && (asked || (batch && (!output.empty() || !errors.sheet.file.empty())));
}

namespace {

void checkGate(RenderCommand& command) {
    ErrorsFlags& errors = command.errors;
    if (!errors.fail_above) return;
    command.gate = errors.gate;
    command.gate->above = *errors.fail_above;
    const std::string metric = "--fail-metric " + std::string(nameOf(errors.gate.figure));
    if (errors.gate.over_run && errors.gate.percent > 0)
        throw UsageError("--fail-percent counts frames, and --fail-per run has one figure for all");
    if (errors.gate.figure != Figure::kOutOfRange && command.truth.empty())
        throw UsageError(metric + " needs --truth X.truth.pnb");
    errors.flip = errors.flip || errors.gate.figure == Figure::kFlip;
}

void checkFrames(RenderCommand& command) {
    FrameChoice& choice = command.frames.choice;
    const ErrorsFlags& errors = command.errors;
    const bool many_clips = choice.clips.size() > 1 || choice.clips == std::vector<std::string>{"all"};
    const bool figures = !errors.csv.empty() || !errors.sheet.file.empty() || command.gate || errors.flip;
    choice.sequence =
        !choice.frame && (choice.frames || many_clips || figures || FramePattern::looksLikeOne(command.output));
    command.batch = choice.sequence || figures;
    const std::string problem = command.output.empty() ? "" : endsIn({".png", ".exr"})(command.output.string());
    if (!problem.empty()) throw UsageError("-o " + problem);
    if (!command.output.empty() && (choice.sequence || FramePattern::looksLikeOne(command.output)))
        FramePattern check(command.output);
    if (command.output.empty() && !figures)
        throw UsageError("nothing to do without -o, --sheet, --csv or --fail-above");
}

void choosePanels(RenderCommand& command) {
    std::vector<SheetPanel>& panels = command.errors.sheet.panels;
    const Channel channel = command.options.channel;
    const bool comparable = channel == Channel::kShaded || channel == Channel::kAmbient;
    for (const SheetPanel panel : panels) {
        if (panel != SheetPanel::kModel && command.truth.empty())
            throw UsageError("--panels truth and error need --truth X.truth.pnb");
        if ((panel == SheetPanel::kTruth && !comparable) || (panel == SheetPanel::kModel && needsTruth(channel)))
            throw UsageError("--panels: --channel " + std::string(nameOf(channel)) +
                             " has no truth to show beside the model");
    }
    if (!panels.empty() || command.errors.sheet.file.empty()) return;
    if (!needsTruth(channel)) panels.push_back(SheetPanel::kModel);
    if (comparable && !command.truth.empty()) panels.push_back(SheetPanel::kTruth);
    if ((comparable && !command.truth.empty()) || needsTruth(channel)) panels.push_back(SheetPanel::kError);
}

// Refuses what would give another result than asked for.
void refuseWrong(const RenderCommand& command) {
    const Channel channel = command.options.channel;
    const std::string in_channel = "--channel " + std::string(nameOf(channel));
    const bool compared = command.errors.flip || (command.gate && command.gate->figure == Figure::kImageRmse);
    const bool shows_overlays = !command.output.empty() && command.errors.sheet.file.empty() && !command.imageError() &&
                                channel != Channel::kNormals;
    if (compared && !command.imageError())
        throw UsageError("--flip and --fail-metric image-rmse compare pictures of --channel shaded or ao, not of " +
                         in_channel);
    if (command.isScene() && channel != Channel::kShaded && channel != Channel::kAmbient && channel != Channel::kError)
        throw UsageError(in_channel + ": a scene is drawn as shaded, ao or error");
    if (command.isScene() && channel == Channel::kError && command.truth.empty())
        throw UsageError(in_channel + " needs --truth X.truth.pnb (penumbra-pack truth makes it)");
    if (!command.compared.empty() && channel != Channel::kShaded) throw UsageError("--compare needs --channel shaded");
    for (const CLI::Option* option : command.app->get_options()) {
        if (option->count() == 0) continue;
        const std::string name = option->get_name(), group = option->get_group();
        const bool of_one = group == kFramesGroup || group == kOverlayGroup || group == kErrorsGroup ||
                            name == "--slot" || name == "--parameter" || name == "--source";
        if (command.isScene() && of_one) throw UsageError(name + " is for one asset, not for a scene");
        if (!command.isScene() && group == kSceneGroup) throw UsageError(name + " is for scenes, not for one asset");
        if (group == kOverlayGroup && !shows_overlays)
            throw UsageError(name + " is drawn on pictures of -o alone, without --sheet, FLIP and --channel normals");
    }
}

// Warns of what changes nothing.
void warnOfUnused(const RenderCommand& command) {
    const RenderOptions& options = command.options;
    const std::string in_channel = "in --channel " + std::string(nameOf(options.channel));
    const auto warn = [](const std::string& name, const std::string& where) {
        reportWarning("penumbra-player", name + " changes nothing " + where);
    };
    for (const CLI::Option* option : command.app->get_options()) {
        if (option->count() == 0) continue;
        const std::string name = option->get_name(), group = option->get_group();
        if (group == kLookGroup && options.channel != Channel::kShaded)
            warn(name, in_channel);
        else if ((group == kLookGroup || group == kPictureGroup) && !command.draws())
            warn(name, "without a picture (-o, --sheet, --flip)");
        else if (name == "--error-max" && !needsTruth(options.channel) &&
                 !showsError(command.errors.sheet, options.channel))
            warn(name, in_channel);
        else if (name == "--source" && command.output.empty())
            warn(name, "without -o");
        else if (name == "--truth" && !command.batch && !needsTruth(options.channel) &&
                 options.source != VisibilitySource::kTruth)
            warn(name, "without a sequence, --channel error or transfer-error, or --source truth");
    }
}

}  // namespace

void checkRender(RenderCommand& command) {
    if (command.assets.empty() && command.scene.empty())
        throw UsageError("an asset, X.pnb, or a --scene S.json is required");
    checkGate(command);
    checkFrames(command);
    choosePanels(command);
    refuseWrong(command);
    warnOfUnused(command);
}

}  // namespace penumbra
