// penumbra-bake poses RIG... -o POSES.(h5|glb|json): the flags and the run.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bake/bake_verbs.h"
#include "bake/pilot/auto_poses.h"
#include "bake/poses/pose_list.h"
#include "bake/rig_flags.h"
#include "bake/source/frame_choice.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/write_file.h"
#include "sh/angles.h"

namespace penumbra {

namespace {
using Json = nlohmann::ordered_json;

constexpr Word<ChoiceMethod> kMethodWords[] = {{"farthest", ChoiceMethod::kFarthest},
                                               {"representative", ChoiceMethod::kRepresentative},
                                               {"random", ChoiceMethod::kRandom}};

constexpr const char* kAllWord = "all";  // of --choose

struct PosesCommand {
    std::vector<std::filesystem::path> rigs;
    std::vector<std::filesystem::path> files_read;  // the rigs and what they refer to, known after reading
    std::filesystem::path output;
    PoseOptions options;
    bool automatic = false;
    AutoOptions automatic_options;
    const CLI::App* app = nullptr;

    std::vector<std::filesystem::path> inputs() const { return files_read.empty() ? rigs : files_read; }
};

// Lists every option that changes the result, defaults included. Those that few lists need are listed only where they
// are used.
std::string optionsJson(const PosesCommand& command) {
    const PoseOptions& options = command.options;
    Json json{{"clips", options.clips}, {"holdout", options.holdout}, {"fps", options.fps}};
    if (options.frames) json["frames"] = {options.frames->begin, options.frames->end, options.frames->step};
    if (options.choose == kAllCandidates)
        json["choose"] = kAllWord;
    else
        json["choose"] = options.choose;
    json["method"] = wordOf(kMethodWords, options.method);
    json["sample"] = options.sample;
    if (options.mix > 0) json["mix"] = options.mix;
    if (options.cover > 0) json["cover"] = options.cover;
    json["seed"] = options.seed;
    listRigOptions(options.rig, json);
    return json.dump();
}

bool isGlb(const PosesCommand& command) { return command.output.extension() == ".glb"; }
bool isJson(const PosesCommand& command) { return command.output.extension() == ".json"; }

void checkOptions(const PosesCommand& command) {
    const PoseOptions& options = command.options;
    refuseTwice(command.rigs);
    if (command.automatic) {
        if (options.choose != 0) throw UsageError("--choose: --auto lists the frames of all clips");
        return;
    }
    for (const char* option : {"--minutes", "--rays"})
        if (command.app->count(option) > 0) throw UsageError(std::string(option) + " goes with --auto");
    if (options.choose != kAllCandidates && options.choose + options.sample + options.mix + options.cover == 0)
        throw UsageError("--choose, --sample, --mix or --cover is needed: how many poses?");
    if (!options.limits.empty() && options.sample == 0) throw UsageError("--limits needs --sample");
}

Json poseTable(const PoseFile& file) {
    Json table = Json::array();
    for (std::size_t f = 0; f < file.frames.frameCount(); ++f)
        table.push_back({{"clip", file.frames.clip_names[file.frames.clip[f]]},
                         {"time", file.frames.time[f]},
                         {"rank", file.rank[f]},
                         {"distance", file.distance[f]}});
    return table;
}

Json limitsTable(const JointLimits& limits, const Skin& skin) {
    Json table = Json::array();
    for (std::size_t c = 0; c < limits.low.size(); ++c)
        if (limits.low[c] != 0 || limits.high[c] != 0)
            table.push_back({{"joint", skin.joint_names[c / 3]},
                             {"axis", std::string(1, "xyz"[c % 3])},
                             {"min", degrees(limits.low[c])},
                             {"max", degrees(limits.high[c])}});
    return table;
}

Json mixFigures(const PoseList& list) {
    Json json{
        {"poses", list.file.mixedCount()}, {"limbs", list.limbs.count}, {"mirrored_limbs", list.limbs.mirroredCount()}};
    if (list.open_before > 0) json["open_before_covering"] = list.open_before;
    if (list.open_before > 0) json["open_after_covering"] = list.open_after;
    return json;
}

void fillReport(const PosePlan& plan, const PoseOptions& options, const PoseList& list, Report& report) {
    Json& figures = report.figures;
    figures["candidates"] = plan.candidates.frameCount();
    figures["chosen"] = list.choice.frames.size();
    figures["sampled"] = list.file.sampledCount();
    if (list.file.mixedCount() > 0) figures["mixed"] = mixFigures(list);
    if (options.choose > 0) {
        figures["largest_gap"] = list.choice.largest_gap;
        figures["mean_gap"] = list.choice.mean_gap;
    }
    for (std::size_t c = 0; c < list.file.frames.clip_names.size(); ++c)
        figures["frames_by_clip"][list.file.frames.clip_names[c]] =
            std::count(list.file.frames.clip.begin(), list.file.frames.clip.end(), std::uint16_t(c));
    figures["poses"] = poseTable(list.file);
    figures["limits_degrees"] = limitsTable(list.limits, plan.rig.skin);
}

void printSummary(const PosesCommand& command, const PosePlan& plan, const PoseList& list) {
    const auto& names = list.file.frames.clip_names;
    std::printf("%s: %zu of %zu frames", command.output.c_str(), list.choice.frames.size(),
                plan.candidates.frameCount());
    if (list.file.sampledCount() > 0) std::printf(", %zu sampled poses", list.file.sampledCount());
    if (list.file.mixedCount() > 0)
        std::printf(", %zu mixed poses of %zu limbs (%zu mirrored)", list.file.mixedCount(), list.limbs.count,
                    list.limbs.mirroredCount());
    std::printf("\n");
    if (list.file.sampledCount() > 0 && plan.rig.clips.empty())
        std::printf(
            "the rig has no clip: joints turn by up to %.0f degrees / sqrt(joints from the root) about each axis, "
            "at least %.0f; --limits sets others\n",
            kFreeTurn, kMinFreeTurn);
    if (list.open_before > 0)
        std::printf("open share of mixed poses: %.4f before the covering ones, %.4f after\n", list.open_before,
                    list.open_after);
    if (command.options.choose <= 0) return;
    if (list.choice.frames.size() < std::size_t(command.options.choose))
        std::printf("all other frames equal a chosen one\n");
    std::printf("distance to the nearest chosen frame: %.4f at most, %.4f mean (of rest diagonals)\n",
                list.choice.largest_gap, list.choice.mean_gap);
    for (std::size_t c = 0; c < names.size(); ++c)
        std::printf(
            "%-24s %6zu\n", names[c].c_str(),
            std::size_t(std::count(list.file.frames.clip.begin(), list.file.frames.clip.end(), std::uint16_t(c))));
}

void writeGlbOfPoses(const PosesCommand& command, const PosePlan& plan, const PoseFile& file) {
    Json extras{{"penumbra_poses", poseTable(file)}, {"provenance", Json::parse(toJson(file.provenance))}};
    writeGlb(command.output, rigOfPoses(plan.rig, file), extras.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Json countsOf(const AutoTrial& tried, std::size_t frames) {
    return {{"options", optionsOf(tried.trial.counts)},
            {"poses", frames + std::size_t(tried.trial.counts.total())},
            {"minutes", tried.minutes},
            {"errors", tried.trial.errors},
            {"ratio", tried.ratio.mean},
            {"noise", tried.ratio.noise}};
}

void reportChoice(const AutoChoice& choice, std::size_t frames, Report& report) {
    Json& json = report.figures["auto"];
    json["chosen"] = optionsOf(choice.counts());
    json["clip_minutes"] = choice.clip_minutes;
    json["pilot"] = {{"minutes", choice.pilot_minutes},
                     {"frames", choice.pilot_frames},
                     {"folds", choice.folds},
                     {"model", choice.composed ? "composed" : "additive"}};
    json["can_mix"] = choice.can_mix;
    json["tried"] = Json::array();
    for (const AutoTrial& tried : choice.tried) json["tried"].push_back(countsOf(tried, frames));
}

void printChoice(const AutoChoice& choice, std::size_t frames) {
    std::printf("pilot: %zu frames in %zu folds, %s fits, %.1f minutes\n", choice.pilot_frames, choice.folds,
                choice.composed ? "composed" : "additive", choice.pilot_minutes);
    if (!choice.can_mix) std::printf("mixed poses: none, as the skeleton has no limbs to mix\n");
    if (choice.tried.empty())
        std::printf("nothing is tried: the clips alone take %.1f minutes, and leave no time for more poses\n",
                    choice.clip_minutes);
    else
        std::printf("%-40s %6s %8s %14s %17s\n", "list", "poses", "minutes", "rms V, unseen", "to clips alone");
    for (std::size_t t = 0; t < choice.tried.size(); ++t) {
        const AutoTrial& tried = choice.tried[t];
        double squares = 0;
        for (const double error : tried.trial.errors) squares += error * error / double(tried.trial.errors.size());
        std::printf("%-40s %6zu %8.1f %14.4f %9.3f +- %.3f%s\n", optionsOf(tried.trial.counts).c_str(),
                    frames + std::size_t(tried.trial.counts.total()), tried.minutes, std::sqrt(squares),
                    tried.ratio.mean, tried.ratio.noise, t == choice.chosen ? "  *" : "");
    }
    std::printf("chosen, to type in place of --auto: %s\n", optionsOf(choice.counts()).c_str());
}

// Sets the numbers of the options by trials.
void chooseCounts(PosesCommand& command, const PosePlan& plan, const CommonOptions& common, Report& report) {
    PoseOptions& options = command.options;
    AutoOptions& wanted = command.automatic_options;
    if (options.sample > 0) wanted.most.sample = options.sample;
    if (options.mix > 0) wanted.most.mix = options.mix;
    if (options.cover > 0) wanted.most.cover = options.cover;
    report.phase("pilot");
    const AutoChoice choice = chooseAutoPoses({command.rigs, plan, options}, wanted, common.threads, common.progress);
    reportChoice(choice, plan.candidates.frameCount(), report);
    if (!common.quiet) printChoice(choice, plan.candidates.frameCount());
    const PoseCounts counts = choice.counts();
    options.choose = counts.mix + counts.cover == 0 ? kAllCandidates : 0;
    options.sample = counts.sample;
    options.mix = counts.mix;
    options.cover = counts.cover;
    if (options.sample == 0) options.limits.clear();
}

void runPoses(PosesCommand& command, const CommonOptions& common, Report& report) {
    checkOptions(command);
    report.phase("read");
    const PosePlan plan = planPoses(command.rigs, command.options);
    command.files_read = plan.rig.files_read;
    reportNotes(plan.notes, report);
    if (common.dry_run) {
        const PoseOptions& options = command.options;
        const std::size_t candidates = plan.candidates.frameCount();
        const bool all = options.choose == kAllCandidates || (options.choose == 0 && options.mix + options.cover > 0);
        if (command.automatic) {
            std::printf("%zu frames; made poses are chosen by trial fits, which --dry-run leaves out\n", candidates);
            return;
        }
        std::printf("%zu of %zu frames, %lld sampled poses", all ? candidates : std::size_t(options.choose), candidates,
                    static_cast<long long>(options.sample));
        if (options.mix + options.cover > 0)
            std::printf(", %lld mixed poses", static_cast<long long>(options.mix + options.cover));
        std::printf("\n");
        return;
    }
    if (command.automatic) chooseCounts(command, plan, common, report);
    if (!command.options.limits.empty()) command.files_read.push_back(command.options.limits);
    report.phase("choose");
    PoseList list = makePoses(plan, command.options, common.threads);
    report.phase("write");
    list.file.provenance = makeProvenance("penumbra-bake poses", optionsJson(command), command.files_read);
    list.file.provenance.notes = plan.notes;
    if (isGlb(command))
        writeGlbOfPoses(command, plan, list.file);
    else if (isJson(command))
        writeWholeFile(command.output, bonePosesText(bonesOfPoses(plan.rig, list.file)));
    else
        writePoseFile(command.output, list.file);
    fillReport(plan, command.options, list, report);
    if (!common.quiet) printSummary(command, plan, list);
}

void definePoses(CLI::App& app, PosesCommand& command) {
    PoseOptions& options = command.options;
    app.add_option("rig", command.rigs, "rig; further files may bring clips only")->required();
    app.add_option("-o,--output", command.output,
                   "X.poses.h5, or X.glb: a rig whose only clip has the poses as its keys, or X.poses.json: bones for "
                   "scene.json")
        ->required()
        ->check(endsIn({".h5", ".glb", ".json"}));
    command.app = &app;
    const CLI::Validator count = within<std::int64_t>(0, INT64_MAX, "frames");
    const auto check = [count](const std::string& text) { return text == kAllWord ? "" : count(text); };
    const auto read = [](const std::string& text) {
        return text == kAllWord ? kAllCandidates : std::int64_t(std::strtoll(text.c_str(), nullptr, 10));
    };
    addParsed(app, "--choose", options.choose, read, "how many of the candidate frames, or all of them")
        ->check(CLI::Validator(check, ""))
        ->default_str("0");
    app.add_flag("--auto", command.automatic,
                 "all candidate frames, and kinds and numbers of --sample, --mix and --cover by trial fits; these then "
                 "say how many poses of a kind there may be (default: 200, 300 and 300)");
    app.add_option("--minutes", command.automatic_options.minutes,
                   "of --auto: how long the bake of the list may take on this machine (default: any time)")
        ->check(aboveZero());
    app.add_option("--rays", command.automatic_options.rays, "of --auto: of that bake, for its minutes")
        ->check(within(16, 1 << 16, "directions above the horizon"));
    addChoice(app, "--method", options.method, kMethodWords,
              "farthest: the most different frames; representative: least mean gap; random: to compare with");
    app.add_option("--sample", options.sample, "how many poses with joint angles sampled within their limits")
        ->check(within(0, 1000000, "poses"));
    app.add_option("--limits", options.limits,
                   "CSV joint,axis,min,max (degrees): limits instead of the candidates' own");
    app.add_option("--mix", options.mix,
                   "how many poses of which each limb follows a random listed frame; without --choose all candidates "
                   "are listed")
        ->check(within(0, 1000000, "poses"));
    app.add_option("--cover", options.cover, "how many such poses that show most of what is not shown yet")
        ->check(within(0, 10000, "poses"));
    addNameListOption(app, "--clips", options.clips, "names of the clips to choose from (default: all)");
    addNameListOption(app, "--holdout", options.holdout,
                      "clips of which no frame is chosen or mixed and no limit taken");
    app.add_option("--fps", options.fps, "candidates a second (default: the clips' own keys)")
        ->check(within(0.0, 1000.0, "samples a second"));
    addFrames(app, options.frames, "A:B[:S], half-open, of the sampled frames of all these clips");
    addRigFlags(app, options.rig);
    addSeed(app, options.seed, "of --method random, --sample (0: plain Halton points), --mix and --cover");
}

}  // namespace

Verb posesVerb() {
    return verbOf<PosesCommand>(
        "poses",
        "Choose the most different frames of many clips, sample poses within joint limits, and mix limbs of frames.",
        definePoses, runPoses);
}

}  // namespace penumbra
