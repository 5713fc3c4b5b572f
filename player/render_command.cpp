// penumbra-player render X.pnb -o OUT.(png|exr): frames as pictures, and their errors.
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/common/name_list_option.h"
#include "formats/common/write_file.h"
#include "player/frame/open_asset.h"
#include "player/player_verbs.h"
#include "player/render/render_sheet.h"
#include "player/render_report.h"

namespace penumbra {

namespace {

struct RenderCommand {
    std::filesystem::path asset, truth, output, csv;
    RenderOptions options;
    FrameChoice choice;
    Framing framing = Framing::kFrame;
    SheetOptions sheet;
    std::optional<ErrorGate> gate;
    bool flip = false;
    bool batch = false;  // the user asks for more than one picture of one frame

    bool draws() const;       // tells whether the run needs OpenGL
    bool imageError() const;  // tells whether pictures of model and truth are compared

    // Values as the user typed them.
    std::string frames, framing_word, fail_figure = "ambient-mean", fail_per = "frame";
    double fail_above = 0, fail_percent = 0;
    std::vector<std::string> panels;
    std::string size, channel = "shaded", source = "model", path = "auto", backend = "auto", background = "transparent";
    std::string reflectance = "slices", light_form = "auto";
    // Options that only --channel shaded, pictures, --sheet and --fail-above read.
    std::vector<const CLI::Option*> shading, picture, sheet_only, gate_only;
    const CLI::Option *frame_option = nullptr, *source_option = nullptr, *error_max_option = nullptr,
                      *fail_option = nullptr;
};

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
    command.picture.insert(command.picture.end(), command.shading.begin(), command.shading.end());
}

void definePicture(CLI::App& app, RenderCommand& command) {
    RenderOptions& options = command.options;
    command.source_option =
        app.add_option("--source", command.source, "visibility of the model or of the truth")->capture_default_str();
    command.error_max_option =
        app.add_option("--error-max", options.error_max, "the error that gets the brightest colour of --channel error")
            ->capture_default_str();
    const std::vector<const CLI::Option*> all = {
        app.add_option("--size", command.size, "WIDTHxHEIGHT in pixels (default: 512x512)"),
        app.add_option("--camera", options.camera,
                       "yaw=,pitch=,fov= (degrees), distance=,target=X/Y/Z; what is not given is framed"),
        app.add_option("--channel", command.channel, "shaded, ao, error, clusters or normals")->capture_default_str(),
        app.add_option("--path", command.path, "where vertices are evaluated: auto, cpu or glsl")
            ->capture_default_str(),
        app.add_option("--gl", command.backend, "auto (a GPU, else software), egl or osmesa")->capture_default_str(),
        app.add_option("--background", command.background, "transparent or R/G/B, linear")->capture_default_str(),
        app.add_option("--aa", options.samples, "samples a pixel: 1, 2, 4 or 8")->capture_default_str(),
        command.source_option,
        command.error_max_option};
    command.picture.insert(command.picture.end(), all.begin(), all.end());
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
                                        "the error: ambient-mean, ambient-max, rms-v, relative, image-rmse, flip or "
                                        "out-of-range")
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

void defineRender(CLI::App& app, RenderCommand& command) {
    app.add_option("asset", command.asset, "X.pnb with a model")->required();
    defineFrames(app, command);
    defineShading(app, command);
    definePicture(app, command);
    defineErrors(app, command);
    defineSheet(app, command);
    defineGate(app, command);
}

// --- From text to values ---------------------------------------------------------------------------------------------

bool RenderCommand::draws() const { return !output.empty() || !sheet.file.empty() || imageError(); }

bool RenderCommand::imageError() const {
    const bool comparable = options.channel == Channel::kShaded || options.channel == Channel::kAmbient;
    const bool asked = flip || (gate && (gate->figure == Figure::kImageRmse || gate->figure == Figure::kFlip));
    return comparable && !truth.empty() && (asked || (batch && (!output.empty() || !sheet.file.empty())));
}

void parseWords(RenderCommand& command) {
    RenderOptions& options = command.options;
    if (!command.size.empty()) parseSize(command.size, options.width, options.height);
    options.channel = parseChannel(command.channel);
    options.source = parseSource(command.source);
    options.path = parsePath(command.path);
    options.backend = parseGlBackend(command.backend);
    options.shading = {parseReflectance(command.reflectance), parseLightForm(command.light_form)};
    options.background = parseBackground(command.background);
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
        if ((panel == SheetPanel::kTruth && !comparable) || (panel == SheetPanel::kModel && channel == Channel::kError))
            throw UsageError("--panels: --channel " + command.channel + " has no truth to show beside the model");
    }
    if (!panels.empty() || command.sheet.file.empty()) return;
    if (channel != Channel::kError) panels.push_back(SheetPanel::kModel);
    if (comparable && !command.truth.empty()) panels.push_back(SheetPanel::kTruth);
    if ((comparable && !command.truth.empty()) || channel == Channel::kError) panels.push_back(SheetPanel::kError);
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
    if (channel != Channel::kShaded) refuse(command.shading, "to --channel " + command.channel);
    if (command.sheet.file.empty()) refuse(command.sheet_only, "without --sheet");
    if (!command.gate) refuse(command.gate_only, "without --fail-above");
    if (command.flip && !command.imageError())
        throw UsageError(command.truth.empty() ? "FLIP needs --truth X.truth.pnb"
                                               : "FLIP is not defined for --channel " + command.channel);
    if (command.gate && command.gate->figure == Figure::kImageRmse && !command.imageError())
        throw UsageError("--fail-metric image-rmse is not defined for --channel " + command.channel);
    if (!command.draws()) refuse(command.picture, "without a picture (-o, --sheet, --flip)");
    if (channel != Channel::kError && !showsError(command.sheet, channel))
        refuse({command.error_max_option}, "to --channel " + command.channel);
    if (command.output.empty()) refuse({command.source_option}, "without -o");
    if (!command.truth.empty() && channel != Channel::kError && command.options.source != VisibilitySource::kTruth &&
        !command.batch)
        throw UsageError("--truth is of no use without --channel error, --source truth or a sequence");
}

// Sets everything above "Values as the user typed them" from what stands below. Throws UsageError, which names option
// and value.
void parseRender(RenderCommand& command) {
    parseWords(command);
    parseGate(command);
    parseFrames(command);
    parsePanels(command);
    checkNames(command);
    refuseUnused(command);
}

// --- The run ---------------------------------------------------------------------------------------------------------

// A plan, and the frames' cells of its contact sheet as they come.
struct RenderRun {
    const RenderCommand& command;
    BatchPlan plan;
    std::vector<SheetCell> cells = {};
};

BatchPlan makePlan(const RenderCommand& command, const AssetView& asset, const AssetView* truth) {
    BatchPlan plan;
    plan.options = command.options;
    RenderOptions look = command.options;
    if (!command.draws()) look.channel = Channel::kAmbient;  // needs neither material nor light
    plan.look = resolveLook(look, asset, truth);
    plan.chosen = chooseFrames(asset, command.choice);
    plan.framing = command.framing;
    if (FramePattern::looksLikeOne(command.output)) {
        const FramePattern pattern(command.output);
        for (const ListedFrame& frame : plan.chosen.frames) plan.files.push_back(pattern.name(frame.listed));
    } else if (!command.output.empty()) {
        plan.files = {command.output};
    }
    plan.panels = picturesOf(command.sheet, command.options.channel);
    plan.relative_error = truth && command.batch;
    plan.image_error = command.imageError();
    plan.flip = command.flip;
    findTruth(plan);
    if (!command.sheet.file.empty()) planSheet(command.sheet, plan);  // too large a sheet fails now
    return plan;
}

// Returns what the run writes besides the verb's own output.
std::vector<std::filesystem::path> moreFiles(const RenderRun& run) {
    std::vector<std::filesystem::path> files;
    if (FramePattern::looksLikeOne(run.command.output)) files = run.plan.files;
    for (const std::filesystem::path& file : {run.command.csv, run.command.sheet.file})
        if (!file.empty()) files.push_back(file);
    return files;
}

void listFiles(const RenderRun& run) {
    const RenderOptions& options = run.plan.options;
    for (std::size_t i = 0; i < run.plan.files.size(); ++i) {
        const ListedFrame& at = run.plan.chosen.frames[i];
        std::printf("would draw frame %zu of clip %s, %d x %d pixels, to %s\n", at.number,
                    std::string(run.plan.look.asset->animation.clips[at.clip].name).c_str(), options.width,
                    options.height, run.plan.files[i].c_str());
    }
    const std::size_t frames = run.plan.chosen.frames.size();
    if (!run.command.sheet.file.empty()) {
        const SheetLayout sheet = planSheet(run.command.sheet, run.plan);
        std::printf("would put %zu frames on %d x %d pixels, to %s\n", frames, sheet.width, sheet.height,
                    run.command.sheet.file.c_str());
    }
    if (!run.command.csv.empty())
        std::printf("would measure %zu frames, to %s\n", frames, run.command.csv.c_str());
    else if (run.command.gate)
        std::printf("would measure %zu frames\n", frames);
}

BatchSink sinkOf(RenderRun& run, Progress& progress) {
    const auto write = [&run](std::size_t i, const Image& picture) {
        const RenderOptions& options = run.plan.options;
        Image image = picture;
        if (options.background) putBehind(image, *options.background);
        const std::filesystem::path& file = run.plan.files[i];
        if (file.extension() == ".png") image = forDisplay(std::move(image), options.channel);
        writeImage(file, image, options.channel == Channel::kShaded ? options.exposure : 1);
    };
    const auto keep = [&run](std::size_t, std::vector<Image> panels) {
        run.cells.push_back(sheetCell(run.command.sheet, run.plan, std::move(panels)));
    };
    return {write, keep, [&progress](std::size_t done) { progress.update(double(done)); }};
}

BatchResult runFrames(RenderRun& run, const CommonOptions& common) {
    Progress progress(parseProgressStyle(common.quiet ? "none" : common.progress), "rendering", "frames",
                      double(run.plan.chosen.frames.size()));
    return runBatch(run.plan, common.threads, sinkOf(run, progress));
}

void runRender(RenderCommand& command, const CommonOptions& common, Report& report) {
    parseRender(command);
    report.phase("read");
    const OpenAsset asset(command.asset);
    std::optional<OpenAsset> truth;
    if (!command.truth.empty()) truth.emplace(command.truth);
    RenderRun run{command, makePlan(command, asset.view, truth ? &truth->view : nullptr)};
    const std::vector<std::filesystem::path> more = moreFiles(run);
    if (!common.depfile.empty() && more.empty() && command.output.empty())
        throw UsageError("--depfile: nothing is written that could depend on anything");
    report.willWrite(more);
    if (common.dry_run) return listFiles(run);

    report.phase("frames");
    const BatchResult result = runFrames(run, common);
    std::optional<Judgement> judgement;
    if (command.gate) judgement = {*command.gate, judge(*command.gate, result.frames, asset.view.animation)};

    report.phase("write");
    if (!command.csv.empty()) writeWholeFile(command.csv, figuresCsv(result.frames, asset.view.animation));
    if (!command.sheet.file.empty())
        writePng(command.sheet.file,
                 finishSheet(command.sheet, run.plan, std::move(run.cells), result.frames,
                             judgement ? &judgement->result : nullptr),
                 1);
    if (command.batch)
        reportBatch(run.plan, result, judgement, common, report);
    else
        reportFrame(run.plan, result, common, report);
    if (judgement && !judgement->result.passed) throw std::runtime_error(judgement->result.message);
}

}  // namespace

Verb renderVerb() {
    const auto command = std::make_shared<RenderCommand>();
    return {"render",
            "Draw frames of an asset, measure them against the truth, without a window.",
            [command](CLI::App& app) { defineRender(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs = {command->asset};
                if (!command->truth.empty()) inputs.push_back(command->truth);
                return inputs;
            },
            [command] {  // a plain name is known before the asset is read
                const bool pattern = FramePattern::looksLikeOne(command->output);
                return pattern ? std::filesystem::path() : command->output;
            },
            [command](const CommonOptions& common, Report& report) { runRender(*command, common, report); },
            true};
}

}  // namespace penumbra
