// Tests which limbs a skeleton has, which are mirror images, and which hang together.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bake/poses/attached_joints.h"
#include "bake/source/frame_choice.h"
#include "tests/bake/limb_rigs.h"

namespace penumbra::test_limbs {
namespace {

using samples::addJoint;
using samples::jointNamed;
using samples::sampleRig;

int limbOf(const Rig& rig, const Limbs& limbs, const std::string& joint) {
    return limbs.limb_of_joint[jointNamed(rig, joint)];
}

TEST(Limbs, OfAManAreTrunkBackHeadArmsAndLegs) {
    const Rig rig = sampleRig("capsule_man.glb");
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.count, 7u);
    EXPECT_EQ(limbOf(rig, limbs, "hips"), 0);
    for (const auto& [top, bottom] : {std::pair("upper_arm.L", "lower_arm.L"), {"thigh.L", "foot.L"}})
        EXPECT_EQ(limbOf(rig, limbs, top), limbOf(rig, limbs, bottom)) << top;
    for (const std::string alone : {"spine", "head", "upper_arm.L", "upper_arm.R", "thigh.L", "thigh.R"})
        for (const std::string other : {"hips", "spine", "head", "upper_arm.L", "upper_arm.R", "thigh.L", "thigh.R"})
            EXPECT_EQ(limbOf(rig, limbs, alone) == limbOf(rig, limbs, other), alone == other) << alone << other;
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j)
        EXPECT_EQ(limbs.limb_of_node[std::size_t(rig.node_of_joint[j])], limbs.limb_of_joint[j]);
}

TEST(Limbs, OfAManAreSymmetric) {
    const Rig rig = sampleRig("capsule_man.glb");
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.mirroredCount(), 7u);
    EXPECT_NEAR(limbs.reflection[0], -1, 0);
    EXPECT_NEAR(limbs.reflection[3], 0, 1e-6);
    for (const std::string left : {"upper_arm.L", "lower_arm.L", "thigh.L", "shin.L", "foot.L"}) {
        const std::size_t l = jointNamed(rig, left), r = jointNamed(rig, left.substr(0, left.size() - 1) + "R");
        EXPECT_EQ(limbs.mirrored_joint[l], int(r)) << left;
        EXPECT_EQ(limbs.mirrored_joint[r], int(l)) << left;
        EXPECT_EQ(limbs.mirrored_limb[std::size_t(limbs.limb_of_joint[l])], limbs.limb_of_joint[r]) << left;
    }
    for (const std::string middle : {"hips", "spine", "head"})
        EXPECT_EQ(limbs.mirrored_joint[jointNamed(rig, middle)], int(jointNamed(rig, middle)));
}

// The same man lying on his side in the bind space, with left and right along z.
TEST(Limbs, ThePlaneMayBeAtAnyAxis) {
    Rig rig = sampleRig("capsule_man.glb");
    const Matrix turn{0, 1, 0, 3, 0, 0, 1, -2, 1, 0, 0, 5}, back = *inverse(turn);  // x, y, z become z, x, y
    for (Vec3& p : rig.mesh.rest_positions) p = toFloat(transformPoint(turn, toDouble(p)));
    for (Matrix& bind : rig.inverse_bind) bind = multiply(bind, back);
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.mirroredCount(), 7u);
    EXPECT_EQ(limbs.reflection[10], -1);
    EXPECT_NEAR(limbs.reflection[11], 10, 1e-6);
}

TEST(Limbs, ChainsHaveOneAndNoMirror) {
    for (const std::string name : {"bend.glb", "influences8.glb", "swing.fbx"}) {
        const Rig rig = sampleRig(name);
        const Limbs limbs = findLimbs(rig, {}, 1);
        EXPECT_EQ(limbs.count, 1u) << name;
        EXPECT_EQ(limbs.mirroredCount(), 0u) << name;
    }
}

// A bone that turns the upper half of the upper arm lies beside the lower arm in the tree, but is no branch.
TEST(Limbs, TwistBonesAreNone) {
    Rig rig = sampleRig("capsule_man.glb");
    const int arm = rig.node_of_joint[jointNamed(rig, "upper_arm.L")];
    const std::size_t twist =
        addJoint(rig, "twist", arm, kIdentityMatrix, [](Vec3 p) { return p.x > 0.2f && p.x < 0.45f && p.y > 1.2f; });
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.count, 7u);
    EXPECT_EQ(limbs.limb_of_joint[twist], limbOf(rig, limbs, "lower_arm.L"));
}

// Targets of an animator move no vertices, and props on one side are no branch of the other.
TEST(Limbs, AsymmetryOfTheTrunkDoesNotHideThatArmsAreMirrorImages) {
    Rig rig = sampleRig("capsule_man.glb");
    const int hips = rig.node_of_joint[jointNamed(rig, "hips")];
    const auto nothing = [](Vec3) { return false; };
    for (const double x : {0.4, 0.7, 0.9}) {
        Matrix aside = kIdentityMatrix;
        aside[3] = x;
        addJoint(rig, "target" + std::to_string(x), hips, aside, nothing);
    }
    EXPECT_EQ(findLimbs(rig, {}, 1).mirroredCount(), 7u);
    Matrix& spine = rig.inverse_bind[jointNamed(rig, "spine")];
    spine[3] -= 0.2;  // the joint now stands 20 cm to the left
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.mirrored_limb[std::size_t(limbOf(rig, limbs, "spine"))], -1);
    EXPECT_EQ(limbs.mirrored_limb[std::size_t(limbOf(rig, limbs, "upper_arm.L"))], limbOf(rig, limbs, "upper_arm.R"));
    EXPECT_EQ(limbs.mirroredCount(), 6u);
}

TEST(Limbs, ALimbWithAJointMoreThanItsImageHasNoMirror) {
    Rig rig = sampleRig("capsule_man.glb");
    const int arm = rig.node_of_joint[jointNamed(rig, "lower_arm.R")];
    Matrix out = kIdentityMatrix;
    out[3] = -0.2;
    addJoint(rig, "hook", arm, out, [](Vec3 p) { return p.x < -0.68f; });
    const Limbs limbs = findLimbs(rig, {}, 1);
    EXPECT_EQ(limbs.mirrored_limb[std::size_t(limbOf(rig, limbs, "upper_arm.L"))], -1);
    EXPECT_EQ(limbs.mirrored_limb[std::size_t(limbOf(rig, limbs, "upper_arm.R"))], -1);
    EXPECT_EQ(limbs.mirroredCount(), 5u);
}

TEST(Limbs, JointsOfOneNodeAreInOneLimb) {
    Rig rig = sampleRig("capsule_man.glb");
    const std::size_t joints = rig.node_of_joint.size(), before = findLimbs(rig, {}, 1).count;
    for (std::size_t j = 0; j < joints; ++j) {  // a second skin in centimetres, with the right half of the man
        rig.skin.joint_names.push_back(rig.skin.joint_names[j] + "#2");
        rig.skin.parents.push_back(rig.skin.parents[j]);
        rig.node_of_joint.push_back(rig.node_of_joint[j]);
        rig.inverse_bind.push_back(multiply(rig.inverse_bind[j], {0.01, 0, 0, 0, 0, 0.01, 0, 0, 0, 0, 0.01, 0}));
    }
    const auto influences = std::size_t(rig.skin.influences);
    for (std::size_t v = 0; v < rig.mesh.vertexCount(); ++v) {
        if (rig.mesh.rest_positions[v].x >= 0) continue;
        rig.mesh.rest_positions[v] *= 100;
        for (std::size_t k = 0; k < influences; ++k)
            if (rig.skin.weights[v * influences + k] > 0) rig.skin.joints[v * influences + k] += std::uint16_t(joints);
    }
    Limbs limbs = findLimbs(rig, {}, 1);
    for (std::size_t j = 0; j < joints; ++j) EXPECT_EQ(limbs.limb_of_joint[j], limbs.limb_of_joint[j + joints]) << j;
    // The half that is 100 times as large is far from the other one, and its length does not count.
    EXPECT_EQ(limbs.count, before);
}

// The hand of some rigs is a child of the root, which the animation moves along with the arm. Arm and trunk must then
// follow the same frame.
TEST(AttachedJoints, AHandUnderTheRootJoinsTheArmToTheTrunk) {
    Rig rig = sampleRig("capsule_man.glb");
    const std::size_t arm = jointNamed(rig, "lower_arm.L");
    const std::vector<RigFrame> source = rigFrames(rig, sampleFrames(rig, {}, 5));
    const Matrix at_rest = restGlobals(rig.nodes)[std::size_t(rig.node_of_joint[arm])];
    const std::size_t hand = addJoint(rig, "hand", -1, at_rest, [](Vec3 p) { return p.x > 0.65f; });
    std::vector<float> values;
    for (const RigFrame& frame : source) {
        std::vector<NodePose> poses = nodePoses(rig, frame);
        const std::vector<Matrix> globals = globalTransforms(rig.nodes, poses);
        const Decomposition parts = decompose(globals[std::size_t(rig.node_of_joint[arm])]);
        poses[std::size_t(rig.node_of_joint[hand])] = {parts.translation, parts.rotation, parts.scale};
        for (const NodePose& pose : poses) appendValues(pose, values);
    }
    rig.clips = {clipOfNodes(rig, values, "reach")};
    const std::vector<RigFrame> frames = rigFrames(rig, sampleFrames(rig, {}, 0));
    EXPECT_EQ(attachedJoints(rig, frames, 2), (std::vector<std::pair<int, int>>{{int(hand), int(arm)}}));
    const Limbs limbs = findLimbs(rig, frames, 2);
    EXPECT_EQ(limbs.count, 6u);
    EXPECT_EQ(limbOf(rig, limbs, "hand"), limbOf(rig, limbs, "upper_arm.L"));
    EXPECT_EQ(limbOf(rig, limbs, "hips"), limbOf(rig, limbs, "upper_arm.L"));
    EXPECT_NE(limbOf(rig, limbs, "hips"), limbOf(rig, limbs, "upper_arm.R"));
    // Without the hand nothing slides.
    const Rig man = sampleRig("capsule_man.glb");
    EXPECT_TRUE(attachedJoints(man, rigFrames(man, sampleFrames(man, {}, 5)), 2).empty());
}

}  // namespace
}  // namespace penumbra::test_limbs
