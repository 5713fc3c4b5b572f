#include "player/render_flags.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/name_list_option.h"

namespace penumbra {

namespace {

// --- Flags -----------------------------------------------------------------------------------------------------------

void defineFrames(CLI::App& app, RenderCommand& command) {
    app.add_option("-o,--output", command.output,
                   "OUT.png or OUT.exr (half floats, colours times coverage); the files of a sequence have %d or %0Nd "
                   "in their name, as out.%04d.png");
    app.add_option("--clip", command.choice.clips,
                   "name of a clip, or how only it begins; any number of them, or all (default: the first for one "
                   "frame, all for a sequence)")
        ->allow_extra_args(false);
    command.frame_option =
        app.add_option("--frame", command.options.frame, "one sampled frame of the clip, from 0")->default_str("0");
    app.add_option("--frames", command.frames,
                   "A:B or A:B:S, half-open: a sequence of the sampled frames of all chosen clips, counted in order");
    command.picture.push_back(app.add_option(
        "--framing", command.framing_word,
        "clips: one camera that holds all frames of the chosen clips; clip: one a clip; frame: each frame as it is "
        "framed alone (default: clips for -o's sequences, else frame)"));
}

void defineShading(CLI::App& app, RenderCommand& command) {
    RenderOptions& options = command.options;
    command.shading = {
        app.add_option(
            "--brdf", options.brdf,
            "name of one material for all parts, or how only it begins (default: what the asset gives each)"),
        app.add_option(
               "--slot", options.slots,
               "SLOT=NAME: the material of a part of the mesh (penumbra-bake info lists the slots); any number of them")
            ->allow_extra_args(false),
        app.add_option("--parameter", options.parameters,
                       "MATERIAL=VALUE: the exponent or width of a live material, or of one over a range; any number")
            ->allow_extra_args(false),
        app.add_option("--light", options.light, "name of the light, or how only it begins (default: the first)"),
        app.add_option("--light-rotation", options.light_rotation,
                       "yaw=,pitch=,roll= or axis=X/Y/Z,angle= (degrees) that the light is turned by"),
        app.add_option("--light-form", command.light_form,
                       "how the light is turned into each vertex' frame: auto, lobes (as fitted), fixed or rotation "
                       "(both exact)")
            ->capture_default_str(),
        app.add_option("--suns", command.suns,
                       "whether the suns of a factored light cast shadows with edges (penumbra-fit light --factor): "
                       "auto, on or off")
            ->capture_default_str(),
        app.add_option("--bounces", command.bounces,
                       "of an asset with light that bounces (penumbra-fit indirect): direct light, indirect light or "
                       "both")
            ->capture_default_str(),
        app.add_option("--sun-map", options.sun_map, "texels a side of a sun's shadow map")->capture_default_str(),
        app.add_option("--reflectance", command.reflectance,
                       "what a material is evaluated from: slices, or the paper's operators")
            ->capture_default_str(),
        app.add_option(
            "--exposure", options.exposure,
            "factor on the colours of a shaded PNG (default: automatic and printed, one for the whole run: the "
            "90th percentile of the luminance of the clips' first frame, in the truth if there is one, is "
            "shown as 0.6)")};
    command.picture.insert(command.picture.end(), command.shading.begin(), command.shading.end());
}

void definePicture(CLI::App& app, RenderCommand& command) {
    RenderOptions& options = command.options;
    command.source_option =
        app.add_option("--source", command.source, "visibility of the model or of the truth")->capture_default_str();
    command.error_max_option =
        app.add_option("--error-max", options.error_max,
                       "the error that gets the brightest colour of --channel error or transfer-error")
            ->capture_default_str();
    const std::vector<const CLI::Option*> all = {
        app.add_option("--size", command.size, "WIDTHxHEIGHT in pixels (default: 512x512)"),
        app.add_option("--camera", options.camera,
                       "yaw=,pitch=,fov= (degrees), distance=,target=X/Y/Z; what is not given is framed"),
        app.add_option("--channel", command.channel,
                       "shaded, ao, error, clusters, normals, parts, ao-bounced or transfer-error")
            ->capture_default_str(),
        app.add_option("--path", command.path, "where vertices are evaluated: auto, cpu or glsl")
            ->capture_default_str(),
        app.add_option("--gl", command.backend, "auto (a GPU, else software), egl or osmesa")->capture_default_str(),
        app.add_option("--background", command.background,
                       "transparent, R/G/B (linear), or light: what the light looks like, behind a shaded picture")
            ->capture_default_str(),
        app.add_option("--aa", options.samples, "samples a pixel: 1, 2, 4 or 8")->capture_default_str(),
        command.source_option,
        command.error_max_option};
    command.picture.insert(command.picture.end(), all.begin(), all.end());
}

void defineOverlays(CLI::App& app, RenderCommand& command) {
    command.lobe_option =
        app.add_option("--lobe", command.lobe, "a vertex of the asset, from 0, whose visibility is drawn as a lobe")
            ->default_str("");
    command.lobe_of_option =
        app.add_option(
               "--lobe-of", command.options.lobe_of,
               "what of a composed visibility: whole, local, far, residual, or what one far part leaves visible "
               "(its joint, or how only its name begins)")
            ->capture_default_str();
    command.overlay = {command.lobe_option,
                       addNameListOption(app, "--boxes", command.options.boxes,
                                         "draw the boxes of the fields of these parts of a composed asset (their "
                                         "joints, or how only a name begins), or all")};
    command.picture.insert(command.picture.end(), command.overlay.begin(), command.overlay.end());
}

constexpr const char* kGroup = "Errors of many frames";

void defineErrors(CLI::App& app, RenderCommand& command) {
    app.add_option("--truth", command.truth,
                   "X.truth.pnb: baked frames, for errors, --channel error and --source truth")
        ->group(kGroup);
    app.add_option("--csv", command.csv, "write the figures of every frame, a row each")
        ->type_name("FILE")
        ->group(kGroup);
    app.add_flag("--flip", command.flip, "measure FLIP between pictures of model and truth, too")->group(kGroup);
}

void defineSheet(CLI::App& app, RenderCommand& command) {
    app.add_option("--sheet", command.sheet.file, "write all frames on one PNG, each with its figures")
        ->type_name("FILE")
        ->group(kGroup);
    command.sheet_only = {
        addNameListOption(app, "--panels", command.panels,
                          "model,truth,error side by side on --sheet (default: all that there are)")
            ->group(kGroup),
        app.add_option("--columns", command.sheet.columns, "frames beside one another on --sheet (default: as fits)")
            ->check(CLI::Range(1, kMaxSheetSide))
            ->default_str("")
            ->group(kGroup),
        app.add_option("--shrink", command.sheet.shrink, "pixels of a picture, each way, that make one of --sheet")
            ->check(CLI::Range(1, kMaxSheetSide))
            ->group(kGroup)};
}

void defineGate(CLI::App& app, RenderCommand& command) {
    command.fail_option =
        app.add_option("--fail-above", command.fail_above,
                       "exit with 4, after everything is written, when an error is above this or cannot be measured")
            ->check(CLI::Range(0.0, 1e9))
            ->default_str("")
            ->group(kGroup);
    command.gate_only = {app.add_option("--fail-metric", command.fail_figure,
                                        "the error: ambient-mean, ambient-max, rms-v, relative, image-rmse, flip, "
                                        "out-of-range or transfer")
                             ->group(kGroup),
                         app.add_option("--fail-per", command.fail_per,
                                        "frame: each frame's error counts; run: one error over all frames")
                             ->check(CLI::IsMember({"frame", "run"}))
                             ->group(kGroup),
                         app.add_option("--fail-percent", command.fail_percent,
                                        "percentage of the frames that may be above the bound, below 100")
                             ->check(CLI::Range(0.0, 99.999))
                             ->group(kGroup)};
}

}  // namespace

void defineRender(CLI::App& app, RenderCommand& command) {
    app.add_option("assets", command.assets,
                   "X.pnb with a model; several stand side by side on a ground, and cast on one another");
    app.add_option("--scene", command.scene,
                   "S.json instead of assets: characters on a ground that cast on one another (docs/scene.md)");
    command.time_option =
        app.add_option("--time", command.time, "of a scene: seconds into everyone's clip (default: as it says)")
            ->check(CLI::Range(0.0, 1e6))
            ->default_str("");
    addCastFlags(app, command.cast);
    command.compare_option =
        app.add_option(
               "--compare", command.compared,
               "of a scene: REF.exr of penumbra-bake reference --scene, of the same size, to print FLIP and RMSE "
               "against")
            ->type_name("FILE");
    command.scene_only = {command.time_option, command.compare_option, app.get_option("--cast"),
                          app.get_option("--cast-exponential")};
    defineFrames(app, command);
    defineShading(app, command);
    definePicture(app, command);
    defineOverlays(app, command);
    defineErrors(app, command);
    defineSheet(app, command);
    defineGate(app, command);
    command.not_of_files = {app.get_option("--brdf"), app.get_option("--light"), app.get_option("--light-rotation")};
    const std::vector<std::string> of_scenes = {"assets",       "--brdf",   "--light",     "--light-rotation",
                                                "--help",       "--scene",  "--time",      "--output",
                                                "--size",       "--camera", "--channel",   "--gl",
                                                "--background", "--aa",     "--exposure",  "--reflectance",
                                                "--light-form", "--path",   "--cast",      "--cast-exponential",
                                                "--compare",    "--truth",  "--error-max", "--suns",
                                                "--sun-map",    "--bounces"};
    for (const CLI::Option* option : app.get_options())
        if (std::find(of_scenes.begin(), of_scenes.end(), option->get_name()) == of_scenes.end())
            command.asset_only.push_back(option);
}

// --- From text to values ---------------------------------------------------------------------------------------------

bool RenderCommand::draws() const { return !output.empty() || !sheet.file.empty() || imageError(); }

bool RenderCommand::imageError() const {
    const bool comparable = options.channel == Channel::kShaded || options.channel == Channel::kAmbient;
    const bool asked = flip || (gate && (gate->figure == Figure::kImageRmse || gate->figure == Figure::kFlip));
    return comparable && !truth.empty() && (asked || (batch && (!output.empty() || !sheet.file.empty())));
}

namespace {

void parseWords(RenderCommand& command) {
    RenderOptions& options = command.options;
    if (!command.size.empty()) parseSize(command.size, options.width, options.height);
    options.channel = parseChannel(command.channel);
    options.source = parseSource(command.source);
    options.path = parsePath(command.path);
    options.backend = parseGlBackend(command.backend);
    options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    options.suns = parseSuns(command.suns);
    options.bounces = parseBounces(command.bounces);
    options.light_background = command.background == "light";
    if (!options.light_background) options.background = parseBackground(command.background);
    if (command.lobe_option->count() > 0) options.lobe = command.lobe;
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
}

void parseGate(RenderCommand& command) {
    if (command.fail_option->count() == 0) return;
    const Figure figure = parseFigure("--fail-metric", command.fail_figure);
    command.gate = ErrorGate{figure, command.fail_above, command.fail_per == "run", command.fail_percent};
    if (command.gate->over_run && command.gate_only.back()->count() > 0)
        throw UsageError("--fail-percent is of no use to --fail-per run");
    if (figure != Figure::kOutOfRange && command.truth.empty())
        throw UsageError("--fail-metric " + command.fail_figure + " needs --truth X.truth.pnb");
    command.flip = command.flip || figure == Figure::kFlip;
}

void parseFrames(RenderCommand& command) {
    FrameChoice& choice = command.choice;
    if (!command.frames.empty()) choice.frames = parseFrameRange(command.frames);
    if (command.frame_option->count() > 0) choice.frame = command.options.frame;
    if (choice.frame && choice.frames)
        throw UsageError("--frame " + std::to_string(*choice.frame) + " and --frames " + command.frames +
                         ": one or the other");
    const bool many_clips = choice.clips.size() > 1 || choice.clips == std::vector<std::string>{"all"};
    const bool figures = !command.csv.empty() || !command.sheet.file.empty() || command.gate || command.flip;
    choice.sequence =
        !choice.frame && (choice.frames || many_clips || figures || FramePattern::looksLikeOne(command.output));
    command.batch = choice.sequence || figures;
    command.framing = choice.sequence && !command.output.empty() ? Framing::kClips : Framing::kFrame;
    if (!command.framing_word.empty()) command.framing = parseFraming(command.framing_word);
}

void parsePanels(RenderCommand& command) {
    std::vector<SheetPanel>& panels = command.sheet.panels;
    for (const std::string& word : command.panels) panels.push_back(parseSheetPanel(word));
    const Channel channel = command.options.channel;
    const bool comparable = channel == Channel::kShaded || channel == Channel::kAmbient;
    for (const SheetPanel panel : panels) {
        if (panel != SheetPanel::kModel && command.truth.empty())
            throw UsageError("--panels truth and error need --truth X.truth.pnb");
        if ((panel == SheetPanel::kTruth && !comparable) || (panel == SheetPanel::kModel && needsTruth(channel)))
            throw UsageError("--panels: --channel " + command.channel + " has no truth to show beside the model");
    }
    if (!panels.empty() || command.sheet.file.empty()) return;
    if (!needsTruth(channel)) panels.push_back(SheetPanel::kModel);
    if (comparable && !command.truth.empty()) panels.push_back(SheetPanel::kTruth);
    if ((comparable && !command.truth.empty()) || needsTruth(channel)) panels.push_back(SheetPanel::kError);
}

void checkNames(const RenderCommand& command) {
    const std::filesystem::path& output = command.output;
    const std::string extension = output.extension();
    if (!output.empty() && extension != ".png" && extension != ".exr")
        throw UsageError(output.string() + ": a picture must be named .png or .exr");
    if (!output.empty() && (command.choice.sequence || FramePattern::looksLikeOne(output))) FramePattern check(output);
    if (!command.sheet.file.empty() && command.sheet.file.extension() != ".png")
        throw UsageError("--sheet " + command.sheet.file.string() + ": must be named .png");
    if (output.empty() && command.sheet.file.empty() && command.csv.empty() && !command.gate)
        throw UsageError("nothing to do without -o, --sheet, --csv or --fail-above");
}

void refuse(const std::vector<const CLI::Option*>& options, const std::string& why) {
    for (const CLI::Option* option : options)
        if (option->count() > 0) throw UsageError(option->get_name() + " is of no use " + why);
}

void refuseUnused(const RenderCommand& command) {
    const Channel channel = command.options.channel;
    if (command.isScene() && channel != Channel::kShaded && channel != Channel::kAmbient && channel != Channel::kError)
        throw UsageError("--channel " + command.channel + ": a scene is drawn as shaded, ao or error");
    if (channel == Channel::kError && command.isScene() && command.truth.empty())
        throw UsageError("--channel error needs --truth X.truth.pnb (penumbra-pack truth makes it)");
    if (channel != Channel::kShaded) refuse({command.compare_option}, "to --channel " + command.channel);
    if (channel != Channel::kShaded) refuse(command.shading, "to --channel " + command.channel);
    if (command.sheet.file.empty()) refuse(command.sheet_only, "without --sheet");
    if (!command.gate) refuse(command.gate_only, "without --fail-above");
    if (command.flip && !command.imageError())
        throw UsageError(command.truth.empty() ? "FLIP needs --truth X.truth.pnb"
                                               : "FLIP is not defined for --channel " + command.channel);
    if (command.gate && command.gate->figure == Figure::kImageRmse && !command.imageError())
        throw UsageError("--fail-metric image-rmse is not defined for --channel " + command.channel);
    if (command.lobe_option->count() == 0) refuse({command.lobe_of_option}, "without --lobe");
    if (channel == Channel::kNormals) refuse(command.overlay, "to --channel normals, whose colours are numbers");
    if (!command.sheet.file.empty()) refuse(command.overlay, "with --sheet");
    if (command.imageError()) refuse(command.overlay, "where pictures of model and truth are compared");
    if (!command.draws()) refuse(command.picture, "without a picture (-o, --sheet, --flip)");
    if (!needsTruth(channel) && !showsError(command.sheet, channel))
        refuse({command.error_max_option}, "to --channel " + command.channel);
    if (command.output.empty()) refuse({command.source_option}, "without -o");
    if (command.output.empty()) refuse(command.overlay, "without -o");
    if (!command.truth.empty() && !needsTruth(channel) && command.options.source != VisibilitySource::kTruth &&
        !command.batch)
        throw UsageError(
            "--truth is of no use without --channel error or transfer-error, --source truth or a sequence");
}

}  // namespace

void parseRender(RenderCommand& command) {
    if (command.assets.empty() == command.scene.empty())
        throw UsageError(command.assets.empty() ? "an asset, X.pnb, or a --scene S.json is required"
                                                : "assets or a --scene: one or the other");
    if (!command.isScene()) refuse(command.scene_only, "to one asset without --scene");
    if (command.isScene()) refuse(command.asset_only, command.scene.empty() ? "to several assets" : "with --scene");
    if (!command.scene.empty()) refuse(command.not_of_files, "with --scene, which says it itself");
    parseWords(command);
    parseGate(command);
    parseFrames(command);
    parsePanels(command);
    checkNames(command);
    refuseUnused(command);
}

}  // namespace penumbra
