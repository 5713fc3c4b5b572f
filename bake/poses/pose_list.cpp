#include "bake/poses/pose_list.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "bake/poses/cover_poses.h"
#include "bake/poses/mix_poses.h"
#include "bake/poses/morph_poses.h"
#include "bake/poses/sample_poses.h"
#include "bake/source/frame_choice.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_morphs.h"
#include "formats/source/source_readers.h"

namespace penumbra {

namespace {

// Returns the clips to choose from: those of the options, or all, without the held-out ones.
std::vector<std::string> candidateClips(const Rig& rig, const PoseOptions& options) {
    for (const std::string& name : options.holdout) checkClipName(rig, "holdout", name);
    std::vector<std::string> clips = options.clips;
    if (clips.empty())
        for (const Clip& clip : rig.clips) clips.push_back(clip.name);
    std::erase_if(clips, [&](const std::string& name) {
        return std::find(options.holdout.begin(), options.holdout.end(), name) != options.holdout.end();
    });
    if (clips.empty() && !rig.clips.empty()) throw BadOption("holdout", "no clip is left to choose from");
    return clips;
}

}  // namespace

PosePlan planPoses(const std::vector<std::filesystem::path>& rigs, const PoseOptions& options) {
    PosePlan plan{readRig(rigs, options.rig), {}, {}};
    for (const RigNote& note : plan.rig.notes) plan.notes.push_back(textOf(note));
    for (const std::string name : {kSampledClip, kMixedClip})
        if (clipIndices(plan.rig, {name})[0] >= 0)
            throw InvalidInput(rigs.front().string() + ": has a clip '" + name + "', the name of " + name +
                               " poses; rename it");
    plan.candidates = sampleFrames(plan.rig, candidateClips(plan.rig, options), options.fps);
    if (options.frames) plan.candidates = sliceFrames(plan.candidates, *options.frames);
    if (options.choose > std::int64_t(plan.candidates.frameCount()))
        throw BadOption("choose", "must be at most " + std::to_string(plan.candidates.frameCount()) +
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

// Returns all candidates in their order, as if they were chosen.
ChosenPoses allOf(std::size_t candidates) {
    ChosenPoses all{std::vector<std::size_t>(candidates), std::vector<double>(candidates, 0)};
    std::iota(all.frames.begin(), all.frames.end(), 0);
    return all;
}

// Lists poses that no clip has as a clip of their own after the others.
void listMade(const char* clip, std::size_t count, PoseFile& out) {
    if (count == 0) return;
    out.frames.clip_names.push_back(clip);
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

namespace {

void checkCanMix(const PosePlan& plan, std::size_t limbs, std::size_t frames) {
    const std::string rig = plan.rig.files_read.at(0).string();
    if (limbs < 2 && plan.rig.mesh.morphs.empty())
        throw BadOption("mix", "mixing and covering need limbs, but the skeleton of " + rig +
                                   " has no fork with two long branches; sample poses instead");
    if (frames < 2)
        throw BadOption("mix", "mixing and covering need at least 2 frames, but only " + std::to_string(frames) +
                                   " of " + rig + " is listed");
}

// Mixes poses of the listed frames. The random ones come first, and the covering ones know them.
void addMixed(const PosePlan& plan, const PoseOptions& options, int threads, PoseList& list) {
    const std::vector<RigFrame> frames = rigFrames(plan.rig, list.file.frames);
    list.limbs = findLimbs(plan.rig, frames, threads);
    checkCanMix(plan, list.limbs.count, frames.size());
    const MixSource source{plan.rig, list.limbs, frames};
    PoseFile& file = list.file;
    file.mixed = mixPoses(source, std::size_t(options.mix), options.seed, threads);
    if (options.cover > 0) {
        std::vector<float> covered = file.mixed;
        for (const RigFrame& frame : frames)
            for (const NodePose& pose : nodePoses(plan.rig, frame)) appendValues(pose, covered);
        const CoveringPoses covering = coverPoses(source, covered, std::size_t(options.cover), options.seed, threads);
        file.mixed.insert(file.mixed.end(), covering.values.begin(), covering.values.end());
        list.open_before = covering.open_before;
        list.open_after = covering.open_after;
    }
    for (const Node& node : plan.rig.nodes) file.node_names.push_back(node.name);
    file.mixed_weights = mixWeights(plan.rig, frames, file.mixedCount(), options.seed);
}

}  // namespace

PoseList makePoses(const PosePlan& plan, const PoseOptions& options, int threads) {
    const std::vector<RigFrame> candidates = rigFrames(plan.rig, plan.candidates);
    const bool mixes = options.mix + options.cover > 0;
    PoseList list;
    list.file.joint_names = plan.rig.skin.joint_names;
    if (options.choose > 0)
        list.choice = choosePoses(poseFeatures(plan.rig, candidates, threads), options, threads);
    else if (mixes || options.choose == kAllCandidates)
        list.choice = allOf(candidates.size());
    listChosen(plan.candidates, list.choice, list.file);
    if (mixes) addMixed(plan, options, threads, list);
    if (options.sample > 0) {
        list.limits =
            plan.rig.clips.empty() ? limitsWithoutClips(plan.rig) : limitsOfFrames(plan.rig, candidates, threads);
        if (!options.limits.empty()) applyLimitsFile(options.limits, plan.rig, list.limits);
        if (plan.rig.clips.empty() && list.limits.low == list.limits.high)
            throw BadOption("sample",
                            "the rig has no clip and no joint below another that can turn, and no limits are given");
        list.file.rotations = samplePoses(plan.rig, list.limits, std::size_t(options.sample), options.seed);
        list.file.sampled_weights = sampleWeights(weightLimits(plan.rig, candidates), std::size_t(options.sample),
                                                  options.seed, list.limits.low.size());
        listMade(kSampledClip, std::size_t(options.sample), list.file);
    }
    listMade(kMixedClip, std::size_t(options.mix + options.cover), list.file);
    if (options.sample + options.mix + options.cover > 0) list.file.weight_names = plan.rig.mesh.morphs.names;
    return list;
}

bool canMix(const PosePlan& plan, int threads) {
    if (plan.candidates.frameCount() < 2) return false;
    if (!plan.rig.mesh.morphs.empty()) return true;
    return findLimbs(plan.rig, rigFrames(plan.rig, plan.candidates), threads).count >= 2;
}

Rig rigOfPoses(const Rig& rig, const PoseFile& poses) {
    Rig out = rig;
    addPoseClips(poses, out);
    const std::vector<RigFrame> frames = rigFrames(out, poses.frames);
    std::vector<float> weights = weightsOf(out, frames);
    out.clips = {clipOfFrames(out, frames, kPosesClip)};
    out.weight_curves.clear();
    addWeightKeys(0, std::move(weights), out);
    return out;
}

BonePoses bonesOfPoses(const Rig& rig, const PoseFile& poses) {
    if (!rig.mesh.morphs.empty())
        throw Unsupported(rig.files_read.at(0).string() +
                          ": has morph targets, whose weights poses of bones do not have; write X.poses.h5 or X.glb");
    Rig posed = rig;
    addPoseClips(poses, posed);
    BonePoses out{rig.skin.joint_names, {}};
    const std::vector<RigFrame> frames = rigFrames(posed, poses.frames);
    for (std::size_t f = 0; f < frames.size(); ++f) {
        RigPose pose = evaluatePose(posed, frames[f].clip, frames[f].time);
        const std::string& clip = poses.frames.clip_names[poses.frames.clip[f]];
        for (const Affine& bone : pose.bones)
            if (!std::ranges::all_of(bone.m, [](float x) { return std::isfinite(x); }))
                throw InvalidInput("clip '" + clip + "', " + std::to_string(poses.frames.time[f]) +
                                   " s: a bone is not finite");
        out.poses.push_back({clip, poses.frames.time[f], std::move(pose.bones), std::move(pose.pose)});
    }
    return out;
}

}  // namespace penumbra
