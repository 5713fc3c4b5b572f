// Tests poses that are mixed from the limbs of frames, and the choice of those that show most that is new.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/poses/cover_poses.h"
#include "bake/poses/mix_poses.h"
#include "bake/poses/pose_features.h"
#include "bake/poses/pose_list.h"
#include "bake/source/frame_choice.h"
#include "formats/common/errors.h"
#include "tests/bake/limb_rigs.h"
#include "tests/difference.h"

namespace penumbra::test_mix_poses {
namespace {

using samples::jointNamed;
using samples::sampleRig;

struct Man {
    Rig rig = sampleRig("capsule_man.glb");
    std::vector<RigFrame> frames = rigFrames(rig, sampleFrames(rig, {}, 5));
    Limbs limbs = findLimbs(rig, frames, 2);
    MixSource source() const { return {rig, limbs, frames}; }
};

std::vector<Matrix> bonesOf(const Rig& rig, const std::vector<NodePose>& poses) {
    const std::vector<Matrix> globals = globalTransforms(rig.nodes, poses);
    std::vector<Matrix> bones;
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j)
        bones.push_back(multiply(globals[std::size_t(rig.node_of_joint[j])], rig.inverse_bind[j]));
    return bones;
}

// How joint j has moved against its parent, in the rest space.
Matrix moveOf(const Rig& rig, const std::vector<Matrix>& bones, std::size_t j) {
    const int parent = rig.skin.parents[j];
    return parent < 0 ? bones[j] : multiply(*inverse(bones[std::size_t(parent)]), bones[j]);
}

// Checks every joint of a mixed pose against the frame that its limb follows.
void expectLimbsOfFrames(const MixSource& source, const std::vector<LimbChoice>& choices) {
    const Rig& rig = source.rig;
    const std::vector<Matrix> mixed = bonesOf(rig, mixPose(source, choices));
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j) {
        const LimbChoice& choice = choices[std::size_t(source.limbs.limb_of_joint[j])];
        const std::vector<Matrix> frame = bonesOf(rig, nodePoses(rig, source.frames[choice.frame]));
        Matrix expected = moveOf(rig, frame, j);
        if (choice.mirrored) {
            const Matrix& mirror = source.limbs.reflection;
            expected = moveOf(rig, frame, std::size_t(source.limbs.mirrored_joint[j]));
            expected = multiply(multiply(mirror, expected), mirror);
        }
        // 4e-7 was measured, because inverse bind matrices are floats.
        EXPECT_LT(largestDifference(moveOf(rig, mixed, j), expected), 2e-6) << rig.skin.joint_names[j];
    }
}

TEST(MixPoses, EachLimbIsThatOfItsFrame) {
    const Man man;
    for (std::size_t p = 0; p < 20; ++p) {
        std::vector<LimbChoice> choices = chooseLimbs(man.source(), 3, p);
        for (LimbChoice& choice : choices) choice.mirrored = false;
        const std::vector<NodePose> mixed = mixPose(man.source(), choices);
        for (std::size_t n = 0; n < mixed.size(); ++n) {
            const std::size_t frame = choices[std::size_t(man.limbs.limb_of_node[n])].frame;
            const NodePose expected = nodePoses(man.rig, man.frames[frame])[n];
            EXPECT_EQ(mixed[n].translation, expected.translation);
            EXPECT_EQ(mixed[n].rotation, expected.rotation);
            EXPECT_EQ(mixed[n].scale, expected.scale);
        }
    }
}

TEST(MixPoses, MirroredLimbsMoveAsTheMirrorImageOfTheirImages) {
    const Man man;
    for (std::size_t p = 0; p < 20; ++p) expectLimbsOfFrames(man.source(), chooseLimbs(man.source(), 1, p));
}

// The man's mesh is symmetric, so that all of him mirrored is the frame seen in a mirror.
TEST(MixPoses, AllLimbsMirroredAreTheMirrorImageOfTheFrame) {
    Man man;
    const auto positions = [&](const std::vector<NodePose>& poses) {
        std::vector<Affine> bones(man.rig.node_of_joint.size());
        const std::vector<Matrix> matrices = bonesOf(man.rig, poses);
        for (std::size_t j = 0; j < bones.size(); ++j)
            std::copy(matrices[j].begin(), matrices[j].end(), bones[j].m.begin());
        std::vector<Vec3> p, n;
        skinVertices(man.rig.mesh, man.rig.skin, man.rig.rest_normals, bones, p, n);
        return p;
    };
    for (const std::size_t f : {2u, 9u, 20u, 40u}) {
        const std::vector<LimbChoice> mirrored(man.limbs.count, {f, true});
        const std::vector<Vec3> image = positions(mixPose(man.source(), mirrored)),
                                frame = positions(nodePoses(man.rig, man.frames[f]));
        Largest worst;
        for (const Vec3 p : frame) {
            double nearest = INFINITY;
            for (const Vec3 q : image) nearest = std::min(nearest, double(length(q - Vec3{-p.x, p.y, p.z})));
            worst.add(nearest);
        }
        EXPECT_LT(worst, 1e-5) << f;  // metres
    }
}

// The file may stand in any pose, with nodes between the joints that move as well, and below a node that turns all.
TEST(MixPoses, MirrorImagesDoNotDependOnTheRestPoseOfTheFile) {
    Man man;
    Rig& rig = man.rig;
    for (Node& node : rig.nodes) node.rotation = multiply(node.rotation, rotationOf({0.3, -0.2, 0.5}));
    const std::size_t arm = jointNamed(rig, "upper_arm.L");
    const int node = rig.node_of_joint[arm];
    // A node takes the place of the arm's, which becomes its child.
    Node between = rig.nodes[std::size_t(node)];
    between.name = "between";
    rig.nodes[std::size_t(node)].name = "carrier";
    between.parent = node;
    between.rotation = rotationOf({0, 0.4, 0});
    between.translation = {0.01, 0.02, 0.03};
    const auto at = rig.nodes.begin() + node + 1;
    rig.nodes.insert(at, between);
    for (std::size_t n = std::size_t(node) + 2; n < rig.nodes.size(); ++n)
        if (rig.nodes[n].parent >= node) ++rig.nodes[n].parent;
    for (int& joint : rig.node_of_joint)
        if (joint >= node) ++joint;
    for (Clip& clip : rig.clips)
        for (Channel& channel : clip.channels)
            if (channel.node > node) ++channel.node;
    man.limbs = findLimbs(rig, man.frames, 1);
    EXPECT_EQ(man.limbs.limb_of_node[std::size_t(node)], man.limbs.limb_of_joint[arm]);
    EXPECT_EQ(man.limbs.mirroredCount(), 7u);
    for (std::size_t p = 0; p < 20; ++p) {
        std::vector<LimbChoice> choices = chooseLimbs(man.source(), 1, p);
        choices[0].mirrored = false;  // the trunk is mirrored in the model space
        expectLimbsOfFrames(man.source(), choices);
    }
}

TEST(MixPoses, ANodeWithAMatrixKeepsIt) {
    Man man;
    const std::size_t arm = jointNamed(man.rig, "lower_arm.L");
    Node& node = man.rig.nodes[std::size_t(man.rig.node_of_joint[arm])];
    const Matrix rest = restTransform(node);
    node.matrix = {rest[0], rest[4], rest[8],  0, rest[1], rest[5], rest[9],  0,
                   rest[2], rest[6], rest[10], 0, rest[3], rest[7], rest[11], 1};
    for (Clip& clip : man.rig.clips)
        std::erase_if(clip.channels, [&](const Channel& c) { return c.node == man.rig.node_of_joint[arm]; });
    man.limbs = findLimbs(man.rig, man.frames, 1);
    EXPECT_EQ(man.limbs.mirroredCount(), 5u);
    for (std::size_t p = 0; p < 20; ++p) expectLimbsOfFrames(man.source(), chooseLimbs(man.source(), 1, p));
}

TEST(MixPoses, BonesThatAreScaledToNothingAreNotMirrored) {
    Man man;
    const auto nodeOf = [&](const char* joint) {
        return std::size_t(man.rig.node_of_joint[jointNamed(man.rig, joint)]);
    };
    const auto stride = [&](RigFrame at) {
        const std::vector<NodePose> poses = nodePoses(man.rig, at);
        return largestDifference(poses[nodeOf("thigh.L")].rotation, poses[nodeOf("thigh.R")].rotation);
    };
    std::vector<float> values;
    std::vector<NodePose> poses = nodePoses(man.rig, *std::ranges::max_element(man.frames, {}, stride));
    for (const NodePose& pose : poses) appendValues(pose, values);
    poses[nodeOf("spine")].scale = {0, 0, 0};
    for (const NodePose& pose : poses) appendValues(pose, values);
    man.rig.clips.push_back(clipOfNodes(man.rig, values, "gone"));
    man.frames = {{int(man.rig.clips.size()) - 1, 1}};
    const std::vector<LimbChoice> mirrored(man.limbs.count, {0, true});
    const std::vector<NodePose> frame = nodePoses(man.rig, man.frames[0]), mixed = mixPose(man.source(), mirrored);
    for (std::size_t n = 0; n < mixed.size(); ++n) {
        EXPECT_LT(largestMagnitude(mixed[n].translation), 2) << n;  // metres
        EXPECT_NEAR(distanceBetween(mixed[n].rotation, std::array<double, 4>{}), 1, 1e-6) << n;
    }
    for (const char* joint : {"head", "upper_arm.L", "upper_arm.R", "lower_arm.L", "lower_arm.R"}) {
        EXPECT_EQ(mixed[nodeOf(joint)].translation, frame[nodeOf(joint)].translation) << joint;
        EXPECT_EQ(mixed[nodeOf(joint)].rotation, frame[nodeOf(joint)].rotation) << joint;
    }
    EXPECT_GT(largestDifference(mixed[nodeOf("thigh.L")].rotation, frame[nodeOf("thigh.L")].rotation), 0.01)
        << "the legs hang on the hips, and are mirrored";
}

TEST(MixPoses, ChoicesFollowTheSeedAndUseEveryFrameAndBothSides) {
    const Man man;
    std::set<std::size_t> used;
    double mirrored = 0;
    for (std::size_t p = 0; p < 500; ++p)
        for (const LimbChoice& choice : chooseLimbs(man.source(), 1, p)) {
            used.insert(choice.frame);
            mirrored += choice.mirrored / 3500.0;
        }
    EXPECT_EQ(used.size(), man.frames.size());
    EXPECT_NEAR(mirrored, 0.5, 0.04);  // 5 standard deviations
    EXPECT_EQ(chooseLimbs(man.source(), 1, 7), chooseLimbs(man.source(), 1, 7));
    EXPECT_NE(chooseLimbs(man.source(), 1, 7), chooseLimbs(man.source(), 1, 8));
    EXPECT_NE(chooseLimbs(man.source(), 1, 7), chooseLimbs(man.source(), 2, 7));
}

TEST(MixPoses, SameForAnyThreadCountAndAPrefixOfMore) {
    const Man man;
    const std::vector<float> one = mixPoses(man.source(), 40, 1, 1);
    for (const int threads : {2, 8}) EXPECT_EQ(mixPoses(man.source(), 40, 1, threads), one);
    const std::vector<float> fewer = mixPoses(man.source(), 9, 1, 2);
    EXPECT_TRUE(std::equal(fewer.begin(), fewer.end(), one.begin()));
    EXPECT_TRUE(mixPoses(man.source(), 0, 1, 2).empty());
    EXPECT_THROW(mixPoses(man.source(), std::size_t(1) << 40, 1, 2), UsageError);
}

// As a clip the poses have the bones that the transforms say.
TEST(MixPoses, TheirClipHasTheirBones) {
    Man man;
    const std::vector<float> values = mixPoses(man.source(), 5, 1, 2);
    man.rig.clips.push_back(clipOfNodes(man.rig, values, "mixed"));
    const std::size_t width = man.rig.nodes.size() * kNodeValues;
    for (std::size_t p = 0; p < 5; ++p) {
        const std::vector<NodePose> poses = nodePosesOf(std::span(values).subspan(p * width, width));
        const std::vector<Matrix> expected = bonesOf(man.rig, poses);
        const RigPose made = evaluatePose(man.rig, int(man.rig.clips.size()) - 1, double(p));
        for (std::size_t j = 0; j < expected.size(); ++j)
            EXPECT_LT(largestDifference(expected[j], toMatrix(made.bones[j])), 1e-6);
    }
}

// --- Covering poses -------------------------------------------------------------------------------------------------

std::vector<float> numbersOf(const Man& man) {
    std::vector<float> values;
    for (const RigFrame& frame : man.frames)
        for (const NodePose& pose : nodePoses(man.rig, frame)) appendValues(pose, values);
    return values;
}

// Where limbs follow different frames, only bones near their border see anything new. The head is one limb and the rest
// another: a foot is more than 2 steps away from both.
TEST(CoverPoses, OnlyWhatTheFramesDoNotShowIsOpen) {
    const Man man;
    const LocalFeatures frames = localFeatures(man.rig, numbersOf(man), 2);
    for (const double open : openShares(frames, frames, 2)) EXPECT_EQ(open, 0);
    std::vector<LimbChoice> choices(man.limbs.count, {4, false});
    choices[std::size_t(man.limbs.limb_of_joint[jointNamed(man.rig, "head")])].frame = 13;
    std::vector<float> nodding;
    for (const NodePose& pose : mixPose(man.source(), choices)) appendValues(pose, nodding);
    LocalFeatures one = localFeatures(man.rig, nodding, 2);
    const double open = openShares(one, frames, 2)[0];
    EXPECT_GT(open, 0);
    const MovingBones bones = movingBones(man.rig);
    for (std::size_t b = 0; b < bones.count(); ++b)
        if (man.rig.skin.joint_names[bones.joint[b]].starts_with("shin") ||
            man.rig.skin.joint_names[bones.joint[b]].starts_with("foot"))
            one.share[b] = 100;  // would show if they were open
    EXPECT_EQ(openShares(one, frames, 2)[0], open);
}

// The measure is taken on other mixed poses, which neither choice has seen: how much the tenth of them with most open
// has open at least, and the worst one. With 10, 40 and
// 150 poses random ones leave 21%, 28% and 18% more open there, and 38%, 57% and 61% in the worst.
TEST(CoverPoses, LeaveLessOpenThanAsManyRandomOnes) {
    const Man man;
    const std::vector<float> frames = numbersOf(man);
    const LocalFeatures unseen = localFeatures(man.rig, mixPoses(man.source(), 500, 99, 2), 2);
    const auto openWith = [&](std::vector<float> more) {
        more.insert(more.end(), frames.begin(), frames.end());
        std::vector<double> open = openShares(unseen, localFeatures(man.rig, more, 2), 2);
        std::sort(open.begin(), open.end());
        return std::pair(open[450], open[499]);
    };
    const auto before = openWith({});
    for (const std::size_t count : {10u, 40u, 150u}) {
        const auto covering = openWith(coverPoses(man.source(), frames, count, 1, 2).values);
        for (const std::uint64_t seed : {1u, 2u, 3u}) {
            const auto random = openWith(mixPoses(man.source(), count, seed, 2));
            EXPECT_LT(covering.first, 0.95 * random.first) << count << " poses, seed " << seed;
            EXPECT_LT(covering.second, 0.9 * random.second) << count << " poses, seed " << seed;
            EXPECT_LT(random.first, before.first);
        }
    }
}

TEST(CoverPoses, SameForAnyThreadCountAndNoPoseTwice) {
    const Man man;
    const std::vector<float> frames = numbersOf(man);
    const CoveringPoses one = coverPoses(man.source(), frames, 30, 1, 1);
    for (const int threads : {2, 8}) EXPECT_EQ(coverPoses(man.source(), frames, 30, 1, threads).values, one.values);
    EXPECT_GT(one.open_before, one.open_after);
    const std::size_t width = man.rig.nodes.size() * kNodeValues;
    ASSERT_EQ(one.values.size(), 30 * width);
    std::set<std::vector<float>> seen;
    for (std::size_t p = 0; p < 30; ++p)
        seen.emplace(one.values.begin() + std::ptrdiff_t(p * width),
                     one.values.begin() + std::ptrdiff_t((p + 1) * width));
    EXPECT_EQ(seen.size(), 30u);
}

// All vertices hang on one bone, so that no bone is near another one.
TEST(CoverPoses, WithoutNeighboursAllPosesAreAlikeAndTheFirstAreTaken) {
    Man man;
    std::fill(man.rig.skin.joints.begin(), man.rig.skin.joints.end(), std::uint16_t(0));
    const CoveringPoses poses = coverPoses(man.source(), numbersOf(man), 3, 1, 2);
    EXPECT_EQ(poses.values.size(), 3 * man.rig.nodes.size() * kNodeValues);
    EXPECT_EQ(poses.open_before, 0);
}

// --- The list -------------------------------------------------------------------------------------------------------

std::filesystem::path samplePath(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

TEST(MixedPoseList, ListsAllCandidatesThenSampledThenMixedOnes) {
    PoseOptions options{.holdout = {"walk"}, .fps = 5, .sample = 2, .mix = 6, .cover = 3};
    const PosePlan plan = planPoses({samplePath("capsule_man.glb")}, options);
    PoseList list = makePoses(plan, options, 2);
    EXPECT_EQ(list.file.frames.clip_names, (std::vector<std::string>{"wave", "squat", "sampled", "mixed"}));
    EXPECT_EQ(list.file.frames.frameCount(), 32u + 2 + 9);
    EXPECT_EQ(list.file.mixedCount(), 9u);
    EXPECT_EQ(list.file.rank.back(), 42u);
    EXPECT_GT(list.open_before, list.open_after);
    options.choose = 4;
    list = makePoses(plan, options, 2);
    EXPECT_EQ(list.file.frames.frameCount(), 4u + 2 + 9);
}

// Every limb of every mixed pose is that of a listed frame, so none is that of a held-out clip.
TEST(MixedPoseList, MixesListedFramesOnly) {
    const PoseOptions options{.holdout = {"walk"}, .fps = 5, .choose = 5, .mix = 20};
    const PosePlan plan = planPoses({samplePath("capsule_man.glb")}, options);
    const PoseList list = makePoses(plan, options, 2);
    FrameList chosen = list.file.frames;
    chosen.clip.resize(5);
    chosen.time.resize(5);
    const std::vector<RigFrame> frames = rigFrames(plan.rig, chosen);
    const MixSource source{plan.rig, list.limbs, frames};
    EXPECT_THAT(chosen.clip_names, testing::Not(testing::Contains("walk")));
    EXPECT_EQ(list.file.mixed, mixPoses(source, 20, options.seed, 1));
}

TEST(MixedPoseList, RigsThatCannotBeMixedAreRefused) {
    const auto refusal = [](const char* rig, const PoseOptions& options) -> std::string {
        try {
            makePoses(planPoses({samplePath(rig)}, options), options, 1);
        } catch (const UsageError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_THAT(refusal("bend.glb", {.fps = 5, .mix = 3}), testing::HasSubstr("no fork"));
    EXPECT_THAT(refusal("bend.glb", {.fps = 5, .cover = 3}), testing::HasSubstr("no fork"));
    EXPECT_THAT(refusal("capsule_man.glb", {.fps = 5, .choose = 1, .mix = 3}), testing::HasSubstr("only 1 of"));
    EXPECT_EQ(refusal("capsule_man.glb", {.fps = 5, .choose = 2, .mix = 3}), "accepted");
}

}  // namespace
}  // namespace penumbra::test_mix_poses
