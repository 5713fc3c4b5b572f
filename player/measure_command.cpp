// penumbra-player measure X.pnb [--truth X.truth.pnb]: the errors of many frames, as a table, a sheet and a gate.
#include <cstdio>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/errors_flags.h"
#include "player/frame/open_asset.h"
#include "player/frames_flags.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/player_verbs.h"
#include "player/render_report.h"
#include "player/unused_flags.h"

namespace penumbra {

namespace {

struct MeasureCommand {
    std::filesystem::path asset, truth;
    RenderOptions options;
    FramesFlags frames;
    ErrorsFlags errors;
    const CLI::App* app = nullptr;  // tells which options were given

    std::optional<ErrorGate> gate;  // checkGate() sets it

    std::vector<std::filesystem::path> inputs() const { return namedFiles({asset, truth}); }
    bool hasSheet() const { return !errors.sheet.file.empty(); }
    // Tells whether the channel can be drawn from the model and from the truth.
    bool comparable() const { return options.channel == Channel::kShaded || options.channel == Channel::kAmbient; }
    // Tells whether pictures of model and truth are asked for by name.
    bool asksForPictures() const {
        return errors.flip || (gate && (gate->figure == Figure::kImageRmse || gate->figure == Figure::kFlip));
    }
    bool comparesPictures() const { return comparable() && !truth.empty() && (asksForPictures() || hasSheet()); }
    bool draws() const { return hasSheet() || comparesPictures(); }
};

void defineMeasure(CLI::App& app, MeasureCommand& command) {
    command.app = &app;
    app.add_option("asset", command.asset, "X.pnb with a model")->required();
    CLI::Option* truth = app.add_option("--truth", command.truth, "X.truth.pnb: baked frames to measure against");
    addErrorsFlags(app, command.errors, truth);
    addFramesFlags(app, command.frames);
    addLookFlags(app, command.options);
    addPictureFlags(app, command.options);
}

// --- What the options say together -----------------------------------------------------------------------------------

void checkGate(MeasureCommand& command) {
    ErrorsFlags& errors = command.errors;
    if (!errors.fail_above) return;
    command.gate = errors.gate;
    command.gate->above = *errors.fail_above;
    if (errors.gate.over_run && errors.gate.percent > 0)
        throw UsageError("--fail-percent counts frames, and --fail-per run has one figure for all");
    if (errors.gate.figure != Figure::kOutOfRange && command.truth.empty())
        throw UsageError("--fail-metric " + std::string(nameOf(errors.gate.figure)) + " needs --truth X.truth.pnb");
    errors.flip = errors.flip || errors.gate.figure == Figure::kFlip;
}

void choosePanels(MeasureCommand& command) {
    std::vector<SheetPanel>& panels = command.errors.sheet.panels;
    const Channel channel = command.options.channel;
    const bool comparable = command.comparable(), has_truth = !command.truth.empty();
    for (const SheetPanel panel : panels) {
        if (panel != SheetPanel::kModel && !has_truth)
            throw UsageError("--panels truth and error need --truth X.truth.pnb");
        if ((panel == SheetPanel::kTruth && !comparable) || (panel == SheetPanel::kModel && needsTruth(channel)))
            throw UsageError("--panels: --channel " + std::string(nameOf(channel)) +
                             " has no truth to show beside the model");
    }
    if (!panels.empty() || !command.hasSheet()) return;
    if (!needsTruth(channel)) panels.push_back(SheetPanel::kModel);
    if (comparable && has_truth) panels.push_back(SheetPanel::kTruth);
    if ((comparable && has_truth) || needsTruth(channel)) panels.push_back(SheetPanel::kError);
}

// Says where an option changes nothing, or "".
std::string unusedWhere(const MeasureCommand& command, const CLI::Option& option) {
    const Channel channel = command.options.channel;
    const std::string &name = option.get_name(), &group = option.get_group();
    const bool look = group == kLookGroup;
    const std::string in_channel = "in --channel " + std::string(nameOf(channel));
    if (look && channel != Channel::kShaded) return in_channel;
    if ((look || group == kPictureGroup) && !command.draws()) return "without pictures (--sheet, --flip)";
    if (name == "--error-max" && !showsError(command.errors.sheet, channel)) return in_channel;
    if (name == "--background" && !command.hasSheet()) return "without --sheet";
    return {};
}

// Throws UsageError where the result would be another one than asked for, and warns of options that change nothing.
void checkMeasure(MeasureCommand& command) {
    checkGate(command);
    choosePanels(command);
    if (command.asksForPictures() && !command.comparesPictures())
        throw UsageError("--flip and --fail-metric image-rmse compare pictures of --channel shaded or ao, not of " +
                         std::string(nameOf(command.options.channel)));
    if (command.options.light_background) throw UsageError("--background light: a sheet has one colour behind all");
    command.frames.choice.sequence = !command.frames.choice.frame;
    warnOfUnused(*command.app, [&command](const CLI::Option& option) { return unusedWhere(command, option); });
}

// --- The run ---------------------------------------------------------------------------------------------------------

BatchPlan planMeasure(const MeasureCommand& command, const AssetView& asset, const AssetView* truth) {
    RenderOptions look = command.options;
    if (!command.draws()) look.channel = Channel::kAmbient;  // needs neither material nor light
    BatchPlan plan{command.options, resolveLook(look, asset, truth)};
    plan.chosen = chooseFrames(asset, command.frames.choice);
    plan.framing = command.frames.framing.value_or(Framing::kFrame);
    plan.panels = picturesOf(command.errors.sheet, command.options.channel);
    plan.relative_error = truth;
    plan.image_error = command.comparesPictures();
    plan.flip = command.errors.flip;
    findTruth(plan);
    if (command.hasSheet()) planSheet(command.errors.sheet, plan);  // too large a sheet fails now
    return plan;
}

void listFiles(const MeasureCommand& command, const BatchPlan& plan) {
    const std::size_t frames = plan.chosen.frames.size();
    if (command.hasSheet()) {
        const SheetLayout sheet = planSheet(command.errors.sheet, plan);
        std::printf("would put %zu frames on %d x %d pixels, to %s\n", frames, sheet.width, sheet.height,
                    command.errors.sheet.file.c_str());
    }
    const std::string to = command.errors.csv.empty() ? "" : ", to " + command.errors.csv.string();
    std::printf("would measure %zu frames%s\n", frames, to.c_str());
}

nlohmann::ordered_json gateJson(const ErrorGate& gate, const GateResult& result) {
    nlohmann::ordered_json json = {
        {"metric", nameOf(gate.figure)},    {"above", gate.above},     {"per", gate.over_run ? "run" : "frame"},
        {"percent", gate.percent},          {"passed", result.passed}, {"failed_frames", result.failed.size()},
        {"frames_without", result.without}, {"run", result.run}};
    if (!result.passed) json["message"] = result.message;
    return json;
}

// The frames as they were measured, and their cells of the contact sheet.
struct MeasuredFrames {
    BatchResult result;
    std::vector<SheetCell> cells;
};

MeasuredFrames measureFrames(const MeasureCommand& command, const BatchPlan& plan, const CommonOptions& common) {
    MeasuredFrames measured;
    Progress progress(common.progress, "measuring", "frames", double(plan.chosen.frames.size()));
    float exposure = 1;
    const auto keep = [&](std::size_t, std::vector<Image> panels) {
        measured.cells.push_back(sheetCell(command.errors.sheet, plan, std::move(panels), exposure));
    };
    measured.result = runBatch(plan, common.threads,
                               {.panels = keep,
                                .progress = [&progress](std::size_t done) { progress.update(double(done)); },
                                .exposure = [&exposure](float factor) { exposure = factor; }});
    return measured;
}

void runMeasure(MeasureCommand& command, const CommonOptions& common, Report& report) {
    checkMeasure(command);
    report.phase("read");
    const OpenAsset asset(command.asset);
    std::optional<OpenAsset> truth;
    if (!command.truth.empty()) truth.emplace(command.truth);
    const BatchPlan plan = planMeasure(command, asset.view, truth ? &truth->view : nullptr);
    const std::vector<std::filesystem::path> files = namedFiles({command.errors.csv, command.errors.sheet.file});
    if (!common.depfile.empty() && files.empty())
        throw UsageError("--depfile: nothing is written that could depend on anything");
    report.willWrite(files);
    if (common.dry_run) return listFiles(command, plan);

    report.phase("frames");
    MeasuredFrames measured = measureFrames(command, plan, common);
    const std::vector<FrameRecord>& frames = measured.result.frames;
    std::optional<GateResult> judged;
    if (command.gate) judged = judge(*command.gate, frames, asset.view.animation);

    report.phase("write");
    if (!command.errors.csv.empty()) writeWholeFile(command.errors.csv, figuresCsv(frames, asset.view.animation));
    if (command.hasSheet())
        writePng(
            command.errors.sheet.file,
            finishSheet(command.errors.sheet, plan, std::move(measured.cells), frames, judged ? &*judged : nullptr), 1);
    reportBatch(plan, measured.result, common, report);
    if (judged) report.figures["gate"] = gateJson(*command.gate, *judged);
    if (judged && !judged->passed) throw std::runtime_error(judged->message);
}

}  // namespace

Verb measureVerb() {
    Verb verb = verbOf<MeasureCommand>("measure", "Measure frames of an asset against the truth, without a window.",
                                       defineMeasure, runMeasure);
    verb.names_outputs = true;
    return verb;
}

}  // namespace penumbra
