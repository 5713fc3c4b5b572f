// Tries kinds of made poses on clips that a fit has not seen.
//
// Problem: more poses of a character's clips help some models and hurt others, and which kinds help depends on the
// clips. Only a fit can tell, and the clips that are held out for the last test must not.
//
// Naive: bake everything and fit everything, once for each combination. That takes many times the bake that is wanted.
//
// Here: a fit of few frames, few points and few clusters says which of two sets of poses is better long before it says
// how good either is. The fits are those of penumbra-fit, run as a program of its own, because stages share files only.
#include "bake/pilot/pose_pilot.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/fields/part_fields.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/common/child_process.h"
#include "formats/common/errors.h"
#include "formats/common/find_program.h"
#include "formats/common/frame_folds.h"
#include "formats/common/joined.h"

namespace penumbra {

namespace {

constexpr const char* kFitProgram = "penumbra-fit";
constexpr std::size_t kFewestFrames = 8;
constexpr std::uint64_t kFitBytes = std::uint64_t(64) << 30;
constexpr double kFitSeconds = 3600;
constexpr double kMinError = 1e-6;     // so that a character that hides nothing has ratios, too
constexpr int kFieldRays = 128;        // of the fields
constexpr double kFieldMegabytes = 1;  // of the fields
constexpr const char* kSampledLabel = "sampled poses";
constexpr const char* kMixedLabel = "mixed poses";

// The frames of a list, without the clips that have none of them.
FrameList selectFrames(const FrameList& all, std::span<const std::size_t> frames) {
    FrameList out;
    int last = -1;
    for (const std::size_t f : frames) {
        if (int(all.clip[f]) != last) out.clip_names.push_back(all.clip_names[all.clip[f]]);
        last = all.clip[f];
        out.clip.push_back(std::uint16_t(out.clip_names.size() - 1));
        out.time.push_back(all.time[f]);
    }
    return out;
}

// At most so many frames, evenly spread. A clip that has none of them is left out: no list of poses may name it.
FrameList thinned(const FrameList& all, std::size_t most) {
    const std::size_t count = all.frameCount(), step = std::max<std::size_t>(1, (count + most - 1) / most);
    std::vector<std::size_t> kept;
    for (std::size_t f = 0; f < count; f += step) kept.push_back(f);
    return selectFrames(all, kept);
}

// A list of poses that has frames of clips only.
PoseFile listOf(const FrameList& frames, const std::vector<std::string>& joints) {
    PoseFile file;
    file.frames = frames;
    file.rank.resize(frames.frameCount());
    std::iota(file.rank.begin(), file.rank.end(), 0u);
    file.distance.assign(frames.frameCount(), 0);
    file.joint_names = joints;
    return file;
}

// Adds the frames of the clip of made poses `name` behind all others.
void listMadePoses(const char* name, std::size_t count, PoseFile& file) {
    if (count == 0) return;
    file.frames.clip_names.emplace_back(name);
    for (std::size_t k = 0; k < count; ++k) {
        file.frames.clip.push_back(std::uint16_t(file.frames.clip_names.size() - 1));
        file.frames.time.push_back(double(k));
        file.rank.push_back(std::uint32_t(file.rank.size()));
        file.distance.push_back(0);
    }
}

// How the name begins under which a trial bake has a run of consecutive frames of one clip and one fold. The name of
// the clip would not do: clips are cut, and may have commas in their names, which separate names on a command line.
std::string labelOf(int fold) { return "fold " + std::to_string(fold) + " run "; }

// Renames the clips of a bake, whose first frames are those of the folds.
void labelClips(std::span<const int> folds, BakePlan& plan) {
    FrameList& frames = plan.header.frames;
    FrameList out{{}, {}, frames.time};
    std::vector<int> source_clip;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const std::size_t clip = frames.clip[f];
        const bool made = f >= folds.size();
        if (f == 0 || clip != frames.clip[f - 1] || (!made && folds[f] != folds[f - 1])) {
            const std::string& name = frames.clip_names[clip];
            out.clip_names.push_back(!made                  ? labelOf(folds[f]) + std::to_string(out.clip_names.size())
                                     : name == kSampledClip ? kSampledLabel
                                                            : kMixedLabel);
            source_clip.push_back(plan.source_clip[clip]);
        }
        out.clip.push_back(std::uint16_t(out.clip_names.size() - 1));
    }
    frames = out;
    plan.source_clip = source_clip;
}

// Runs penumbra-fit and returns the figures of its report.
nlohmann::json runFit(std::vector<std::string> command, const std::filesystem::path& folder) {
    const std::filesystem::path report = folder / "fit.json";
    command.insert(command.end(), {"--report", report.string(), "-q"});
    std::string problem;
    try {
        const ProgramResult result = runProgram({command, folder, {kFitBytes, kFitSeconds}});
        if (result.status == 0) return nlohmann::json::parse(std::ifstream(report)).at("figures");
        problem = result.output.empty() ? "status " + std::to_string(result.status) : result.output;
    } catch (const ChildFailed& how) {
        problem = how.what();
    } catch (const nlohmann::json::exception& wrong) {
        problem = std::string("its report: ") + wrong.what();
    }
    while (!problem.empty() && problem.back() == '\n') problem.pop_back();
    throw std::runtime_error(std::string("a trial fit failed: ") + problem);
}

std::filesystem::path fitProgram() {
    if (const auto found = findOwnProgram(kFitProgram)) return *found;
    throw BadOption("auto", "needs " + std::string(kFitProgram) +
                                " for its trial fits, which is neither beside penumbra-bake nor in PATH");
}

}  // namespace

PosePilot::PosePilot(const PilotInput& input, const PilotOptions& options)
    : input_(input), options_(options), fit_(fitProgram()), frames_(thinned(input.plan.candidates, options.frames)) {
    if (frames_.frameCount() < kFewestFrames)
        throw BadOption("auto", "needs at least " + std::to_string(kFewestFrames) +
                                    " frames of clips to try poses on, not " + std::to_string(frames_.frameCount()) +
                                    "; sample or mix a number of your own");
    std::vector<std::size_t> all(frames_.frameCount());
    std::iota(all.begin(), all.end(), std::size_t(0));
    fold_of_frame_ = makeFolds(frames_, all, options.folds);
    folds_ = std::size_t(*std::ranges::max_element(fold_of_frame_)) + 1;
    FieldOptions field_options;
    field_options.rays = kFieldRays;
    field_options.megabytes = kFieldMegabytes;
    field_options.rig = input.options.rig;
    const FieldPlan plan = planFields(input.rigs, field_options);
    if (plan.file.partCount() < 2) return;
    fields_ = folder_.path() / "x.fields.h5";
    writeFields(fields_, bakeFields(plan, field_options, input.threads, ProgressStyle::kNone));
}

// Returns the plan of a list whose candidates are the frames of all other folds.
PosePlan PosePilot::planWithout(int fold) const {
    std::vector<std::size_t> train;
    for (std::size_t f = 0; f < frames(); ++f)
        if (fold_of_frame_[f] != fold) train.push_back(f);
    return {input_.plan.rig, selectFrames(frames_, train), {}};
}

bool PosePilot::canMix() const {
    for (std::size_t fold = 0; fold < folds_; ++fold)
        if (!penumbra::canMix(planWithout(int(fold)), input_.threads)) return false;
    return true;
}

// Bakes all frames, and the poses that are made from all other folds. Returns the frames under their labels.
FrameList PosePilot::bakeFold(int fold, const std::filesystem::path& output) const {
    PoseOptions options = input_.options;
    options.choose = kAllCandidates;
    options.sample = options_.made.sample;
    options.mix = options_.made.mix;
    options.cover = options_.made.cover;
    PoseFile file = makePoses(planWithout(fold), options, input_.threads).file;
    PoseFile all = listOf(frames_, file.joint_names);
    listMadePoses(kSampledClip, file.sampledCount(), all);
    listMadePoses(kMixedClip, file.mixedCount(), all);
    file.frames = all.frames;
    file.rank = all.rank;
    file.distance = all.distance;
    const std::filesystem::path list = folder_.path() / "x.poses.h5";
    writePoseFile(list, file);

    BakeOptions bake;
    bake.poses = list;
    bake.rig = input_.options.rig;
    bake.points = options_.points;
    bake.rays = options_.rays;
    if (composed()) bake.local = LocalMoments{};
    BakePlan plan = planBake(input_.rigs, bake);
    labelClips(fold_of_frame_, plan);
    bakeVisibility(plan, bake, {output}, input_.threads, ProgressStyle::kNone);
    return plan.header.frames;
}

// Fits to the frames of all other folds and the first poses of each kind. Returns the error on the fold's frames.
double PosePilot::errorOf(int fold, const FrameList& baked, const PoseCounts& kind) const {
    const std::string own = labelOf(fold);
    std::vector<std::size_t> train;
    std::vector<std::string> holdout;
    for (const std::string& name : baked.clip_names)
        if (name.starts_with(own)) holdout.push_back(name);
    for (std::size_t f = 0; f < baked.frameCount(); ++f) {
        const std::string& name = baked.clip_names[baked.clip[f]];
        const auto row = std::int64_t(baked.time[f]);
        const bool kept = name == kSampledLabel ? row < kind.sample
                          : name == kMixedLabel
                              ? row < kind.mix || (row >= options_.made.mix && row < options_.made.mix + kind.cover)
                              : !name.starts_with(own);
        if (kept) train.push_back(f);
    }
    const std::filesystem::path list = folder_.path() / "train.poses.h5", folder = folder_.path();
    writePoseFile(list, listOf(selectFrames(baked, train), input_.plan.rig.skin.joint_names));
    std::vector<std::string> command = {fit_.string(),
                                        "visibility",
                                        (folder / "x.vis.h5").string(),
                                        "-o",
                                        (folder / "x.model.h5").string(),
                                        "--holdout",
                                        joined(holdout, ","),
                                        "--train-frames",
                                        list.string(),
                                        "--threads",
                                        std::to_string(input_.threads)};
    // A fit that decides on near parts by itself takes several times as long. Rays beside the fields would take 40% of
    // the time of what is left.
    if (composed())
        command.insert(command.end(), {"--fields", fields_.string(), "--near", "on", "--compared-vertices", "0"});
    if (input_.plan.rig.skin.jointCount() < 2) command.insert(command.end(), {"--features", "joint-angles"});
    command.insert(command.end(), {"--clusters", std::to_string(options_.clusters)});
    return std::max(kMinError, runFit(command, folder).at("held_out").at("rms_v").get<double>());
}

std::vector<std::vector<double>> PosePilot::errorsOf(std::span<const PoseCounts> kinds) const {
    const auto step = [&] {
        if (input_.step) input_.step();
    };
    std::vector<std::vector<double>> errors(kinds.size());
    for (std::size_t fold = 0; fold < folds_; ++fold) {
        const FrameList baked = bakeFold(int(fold), folder_.path() / "x.vis.h5");
        step();
        for (std::size_t k = 0; k < kinds.size(); ++k) {
            errors[k].push_back(errorOf(int(fold), baked, kinds[k]));
            step();
        }
    }
    return errors;
}

}  // namespace penumbra
