#pragma once
// The stage of `penumbra-bake poses`: it reads a rig and writes a list of poses.
#include <filesystem>
#include <string>
#include <vector>

#include "bake/common/bake_options.h"
#include "bake/poses/choose_poses.h"
#include "bake/poses/joint_limits.h"
#include "bake/poses/limbs.h"
#include "formats/scene/bone_poses.h"
#include "formats/stage/pose_file.h"

namespace penumbra {

enum class ChoiceMethod { kFarthest, kRepresentative, kRandom };

constexpr std::int64_t kAllCandidates = -1;

struct PoseOptions {
    // The candidates are chosen as in BakeOptions, without the held-out clips.
    std::vector<std::string> clips = {};
    std::vector<std::string> holdout = {};
    double fps = 0;
    std::optional<FrameRange> frames = {};
    std::int64_t choose = 0;  // candidates to choose, 0..their number; kAllCandidates: all in the clips' order
    ChoiceMethod method = ChoiceMethod::kFarthest;
    std::int64_t sample = 0;            // poses to sample within joint limits, 0..1e6
    std::filesystem::path limits = {};  // CSV of joint_limits.h; "": all limits come from the candidates
    // Poses to mix from the listed frames (mix_poses.h), 0..1e6, and those that cover most (cover_poses.h), 0..10000.
    // With these all candidates are listed unless `choose` says otherwise.
    std::int64_t mix = 0, cover = 0;
    std::uint64_t seed = 1;  // seeds the random choice, the sampling and the mixing
    RigOptions rig = {};
};

struct PosePlan {
    Rig rig;
    FrameList candidates;
    std::vector<std::string> notes;  // notes of the rig's reader, one line each
};
// Reads the rig and finds the candidates. Throws UsageError, IoError and InvalidInput.
PosePlan planPoses(const std::vector<std::filesystem::path>& rigs, const PoseOptions& options);

struct PoseList {
    PoseFile file;                           // without provenance
    ChosenPoses choice;                      // chosen among the candidates; empty if none are to be chosen
    JointLimits limits;                      // empty when nothing is sampled
    Limbs limbs;                             // without joints when nothing is mixed
    double open_before = 0, open_after = 0;  // see CoveringPoses
};
// Chooses, samples and mixes the poses. The result is the same for any number of threads.
PoseList makePoses(const PosePlan& plan, const PoseOptions& options, int threads);

// Tells whether poses can be mixed from the candidates: the skeleton has limbs or the mesh has morph targets, and there
// are two frames.
bool canMix(const PosePlan& plan, int threads);

// Returns the rig with the poses as its only clip, "poses": pose k stands at k seconds (rig_poses.h).
Rig rigOfPoses(const Rig& rig, const PoseFile& poses);
constexpr const char* kPosesClip = "poses";

// Returns the bones of all poses of the list, for scenes. Throws InvalidInput for a pose whose bones are not finite.
BonePoses bonesOfPoses(const Rig& rig, const PoseFile& poses);

}  // namespace penumbra
