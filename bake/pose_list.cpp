#include "bake/pose_list.h"

#include <algorithm>
#include <numeric>
#include <sstream>

#include "bake/frame_choice.h"
#include "bake/sample_poses.h"
#include "formats/common/errors.h"

namespace penumbra {

constexpr std::int64_t kMaxSampled = 1000000;

std::string findProblem(const PoseOptions& options) {
    if (!(options.fps >= 0 && options.fps <= 1000)) {
        std::ostringstream text;
        text << "--fps must be 0..1000 samples a second, not " << options.fps;
        return text.str();
    }
    if (options.choose < 0) return "--choose must be 0 or more frames, not " + std::to_string(options.choose);
    if (options.sample < 0 || options.sample > kMaxSampled)
        return "--sample must be 0..1000000 poses, not " + std::to_string(options.sample);
    if (options.choose + options.sample == 0) return "--choose or --sample is needed: how many poses?";
    if (!options.limits.empty() && options.sample == 0) return "--limits needs --sample";
    return "";
}

namespace {

// Returns the clips to choose from: those of the options, or all, without the held-out ones.
std::vector<std::string> candidateClips(const Rig& rig, const PoseOptions& options) {
    for (const std::string& name : options.holdout) checkClipName(rig, "--holdout", name);
    std::vector<std::string> clips = options.clips;
    if (clips.empty())
        for (const Clip& clip : rig.clips) clips.push_back(clip.name);
    std::erase_if(clips, [&](const std::string& name) {
        return std::find(options.holdout.begin(), options.holdout.end(), name) != options.holdout.end();
    });
    if (clips.empty() && !rig.clips.empty()) throw UsageError("--holdout: no clip is left to choose from");
    return clips;
}

}  // namespace

PosePlan planPoses(const std::vector<std::filesystem::path>& rigs, const PoseOptions& options) {
    PosePlan plan{readRig(rigs), {}};
    if (clipIndices(plan.rig, {kSampledClip})[0] >= 0)
        throw InvalidInput(rigs.front().string() + ": has a clip 'sampled', the name of sampled poses; rename it");
    plan.candidates = sampleFrames(plan.rig, candidateClips(plan.rig, options), options.fps);
    if (options.frames) plan.candidates = sliceFrames(plan.candidates, *options.frames);
    if (options.choose > std::int64_t(plan.candidates.frameCount()))
        throw UsageError("--choose must be at most " + std::to_string(plan.candidates.frameCount()) +
                         ", the number of candidate frames, not " + std::to_string(options.choose));
    return plan;
}

namespace {

// Lists the chosen candidates in the order of the clips, each with its rank. Clips without a chosen frame are left
// out.
void listChosen(const FrameList& candidates, const ChosenPoses& choice, PoseFile& out) {
    std::vector<std::size_t> by_frame(choice.frames.size());
    std::iota(by_frame.begin(), by_frame.end(), 0);
    std::sort(by_frame.begin(), by_frame.end(),
              [&](std::size_t a, std::size_t b) { return choice.frames[a] < choice.frames[b]; });
    for (const std::size_t rank : by_frame) {
        const std::size_t f = choice.frames[rank];
        const std::string& clip = candidates.clip_names[candidates.clip[f]];
        if (out.frames.clip_names.empty() || out.frames.clip_names.back() != clip)
            out.frames.clip_names.push_back(clip);
        out.frames.clip.push_back(std::uint16_t(out.frames.clip_names.size() - 1));
        out.frames.time.push_back(candidates.time[f]);
        out.rank.push_back(std::uint32_t(rank));
        out.distance.push_back(choice.distance[rank]);
    }
}

// Lists the sampled poses as a clip of their own after the chosen ones.
void listSampled(std::size_t count, PoseFile& out) {
    if (count == 0) return;
    out.frames.clip_names.push_back(kSampledClip);
    for (std::size_t i = 0; i < count; ++i) {
        out.frames.clip.push_back(std::uint16_t(out.frames.clip_names.size() - 1));
        out.frames.time.push_back(double(i));
        out.rank.push_back(std::uint32_t(out.rank.size()));
        out.distance.push_back(0);
    }
}

ChosenPoses choosePoses(const PoseFeatures& features, const PoseOptions& options, int threads) {
    const auto count = std::size_t(options.choose);
    switch (options.method) {
        case ChoiceMethod::kFarthest:
            return chooseFarthest(features, count, threads);
        case ChoiceMethod::kRepresentative:
            return chooseRepresentative(features, count, threads);
        case ChoiceMethod::kRandom:
            return chooseRandom(features, count, options.seed, threads);
    }
    return {};
}

}  // namespace

PoseList makePoses(const PosePlan& plan, const PoseOptions& options, int threads) {
    const std::vector<RigFrame> candidates = rigFrames(plan.rig, plan.candidates);
    PoseList list;
    list.file.joint_names = plan.rig.skin.joint_names;
    if (options.choose > 0) {
        list.choice = choosePoses(poseFeatures(plan.rig, candidates, threads), options, threads);
        listChosen(plan.candidates, list.choice, list.file);
    }
    if (options.sample > 0) {
        list.limits = limitsOfFrames(plan.rig, candidates, threads);
        if (!options.limits.empty()) applyLimitsFile(options.limits, plan.rig, list.limits);
        list.file.rotations = samplePoses(plan.rig, list.limits, std::size_t(options.sample), options.seed);
        listSampled(std::size_t(options.sample), list.file);
    }
    return list;
}

Rig rigOfPoses(const Rig& rig, const PoseFile& poses) {
    Rig out = rig;
    if (poses.sampledCount() > 0) out.clips.push_back(clipOfRotations(rig, poses.rotations, kSampledClip));
    out.clips = {clipOfFrames(out, rigFrames(out, poses.frames), kPosesClip)};
    return out;
}

}  // namespace penumbra
