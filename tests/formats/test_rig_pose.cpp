// Tests poses, frames and the joints of rigid things on the synthetic rigs. Every expected number is a closed form.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/rig/frame_sampling.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_pose {
namespace {

using samples::readSample;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<Vec3> posed(const Rig& rig, int clip, double time) {
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, clip, time).bones, positions, normals);
    return positions;
}

double volume(const Mesh& mesh, const std::vector<Vec3>& p) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles)
        sum += dot(toDouble(p[t[0]]), cross(toDouble(p[t[1]]), toDouble(p[t[2]]))) / 6;
    return sum;
}

int indexOf(const std::vector<std::string>& names, const std::string& name) {
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == name) return int(i);
    return -1;
}

TEST(RigPose, RestPoseOfTheTubeIsTheFile) {
    const Rig rig = readSample("bend");
    EXPECT_EQ(rig.mesh.vertexCount(), 506u);
    EXPECT_EQ(rig.mesh.triangles.size(), 1008u);
    EXPECT_THAT(rig.skin.joint_names, ElementsAre("lower", "upper"));
    EXPECT_THAT(rig.skin.parents, ElementsAre(-1, 0));
    EXPECT_EQ(rig.skin.influences, 2);
    EXPECT_EQ(posed(rig, -1, 0), rig.mesh.rest_positions);
    // The volume of a prism over a regular 24-gon of radius r and height h is 12 r^2 sin(15 degrees) h.
    EXPECT_NEAR(volume(rig.mesh, rig.mesh.rest_positions), 12 * 0.01 * std::sin(std::numbers::pi / 12), 1e-6);
}

// At 1 s of "bend" the upper bone is turned by 150 degrees about z at (0, 0.5, 0).
TEST(RigPose, BentTubeTurnsItsEndAboutTheJoint) {
    const Rig rig = readSample("bend");
    const RigPose pose = evaluatePose(rig, indexOf({"bend", "twist", "sway"}, "bend"), 1.0);
    const double a = 150 * std::numbers::pi / 180;
    const Vec3 tip = pose.bones[1].point({0, 1, 0});
    EXPECT_NEAR(tip.x, -0.5 * std::sin(a), 1e-6);
    EXPECT_NEAR(tip.y, 0.5 + 0.5 * std::cos(a), 1e-6);
    EXPECT_NEAR(tip.z, 0, 1e-6);
    EXPECT_THAT(pose.pose, testing::Pointwise(testing::FloatNear(1e-6f), std::vector<float>{0, 0, 0, 0, 0, float(a)}));
}

// Every reader of the rest transforms relies on this: their product along the chain and the inverse bind matrices are
// the skinning matrices of the rest pose.
TEST(RigPose, RestTransformsMakeTheRestPose) {
    for (const char* name : {"bend", "capsule_man", "interpolation", "matrix_nodes", "props"}) {
        const Rig rig = readSample(name);
        const RigPose rest = evaluatePose(rig, -1, 0);
        ASSERT_EQ(rig.skin.rest_transforms.size(), rig.skin.jointCount()) << name;
        for (std::size_t j = 0; j < rig.skin.jointCount(); ++j)
            for (const Vec3 p : {Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
                Vec3 at = rig.skin.inverse_bind[j].point(p);
                for (int k = int(j); k >= 0; k = rig.skin.parents[std::size_t(k)])
                    at = rig.skin.rest_transforms[std::size_t(k)].point(at);
                EXPECT_LT(length(at - rest.bones[j].point(p)), 2e-6f) << name << " joint " << j;
            }
    }
}

TEST(RigPose, RotationVectorsAreRelativeToRestAndAtMostPi) {
    for (const char* name : {"bend", "capsule_man", "interpolation", "matrix_nodes", "props"}) {
        const Rig rig = readSample(name);
        for (const float v : evaluatePose(rig, -1, 0).pose) EXPECT_NEAR(v, 0, 1e-7) << name;
        for (std::size_t clip = 0; clip < rig.clips.size(); ++clip)
            for (double t = 0; t <= rig.clips[clip].duration; t += 0.1) {
                const RigPose pose = evaluatePose(rig, int(clip), t);
                ASSERT_EQ(pose.pose.size(), 3 * rig.skin.jointCount());
                for (std::size_t j = 0; j < rig.skin.jointCount(); ++j)
                    EXPECT_LE(std::hypot(pose.pose[3 * j], pose.pose[3 * j + 1], pose.pose[3 * j + 2]),
                              std::numbers::pi + 1e-6);
            }
    }
}

// Between keys at 0.5 s (value 1) and 1.0 s (value 2), STEP keeps its value, and times outside are clamped.
TEST(RigPose, StepHoldsAndTimesClamp) {
    const Rig rig = readSample("interpolation");
    const auto x = [&](double t) { return evaluatePose(rig, 0, t).bones[0].translation().x; };
    EXPECT_FLOAT_EQ(x(0), 0);
    EXPECT_FLOAT_EQ(x(0.5), 0.1f);
    EXPECT_FLOAT_EQ(x(0.999), 0.1f);
    EXPECT_FLOAT_EQ(evaluatePose(rig, 0, 1.2).bones[0].translation().y, 0.2f);
    EXPECT_EQ(evaluatePose(rig, 0, 99).bones, evaluatePose(rig, 0, 1.5).bones);
    EXPECT_EQ(evaluatePose(rig, 0, -1).bones, evaluatePose(rig, 0, 0.25).bones);
}

TEST(RigPose, SplineGoesThroughItsKeys) {
    const Rig rig = readSample("interpolation");
    EXPECT_NEAR(evaluatePose(rig, 1, 0.5).bones[0].translation().x, 0.1, 1e-6);
    EXPECT_NEAR(evaluatePose(rig, 1, 1.0).bones[0].translation().y, 0.2, 1e-6);
    // This is half way from 0.25 s to 0.5 s: (v0 + v1) / 2 + d (b0 - a1) / 8, where b0 = -0.9 v1 and a1 = -0.9 v0 =
    // 0.
    EXPECT_NEAR(evaluatePose(rig, 1, 0.375).bones[0].translation().x, 0.05 - 0.25 * 0.9 * 0.1 / 8, 1e-6);
}

// Each closed body of the props file keeps its volume, and so its outside, even the mirrored shield.
TEST(RigJoints, RigidThingsMoveWithTheirJointOrTheirOwn) {
    const Rig rig = readSample("props");
    EXPECT_THAT(rig.skin.joint_names, testing::UnorderedElementsAre("lower", "upper", "flag", "bird", "scene"));
    EXPECT_EQ(rig.skin.parents[std::size_t(indexOf(rig.skin.joint_names, "flag"))],
              indexOf(rig.skin.joint_names, "upper"));
    EXPECT_EQ(rig.skin.parents[std::size_t(indexOf(rig.skin.joint_names, "bird"))], -1);
    // The bodies are tube (octagonal prism), sword, shield, flag, tassel, body and ground.
    const double sword = 0.05 * 0.6 * 0.02 * 0.75, shield = 0.3 * 0.4 * 0.04, flag = 0.2 * 0.1 * 0.01;
    const double expected = 4 * 0.01 * std::sin(std::numbers::pi / 4) + sword + shield + flag + 0.02 * 0.1 * 0.02 +
                            0.1 * 0.1 * 0.2 + 2 * 0.02 * 2;
    EXPECT_NEAR(volume(rig.mesh, posed(rig, -1, 0)), expected, 1e-6);
}

// A strip and a fan lie in the node's xy plane, mirrored by their node, under a matrix that turns z to y.
TEST(RigJoints, StripsFansAndMirrorsFaceOutside) {
    const Rig rig = readSample("matrix_nodes");
    ASSERT_EQ(rig.mesh.source_vertex.size(), 82u);
    EXPECT_EQ(rig.mesh.triangles.size(), 148u);
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, -1, 0).bones, positions, normals);
    for (std::size_t v = 74; v < 82; ++v) EXPECT_NEAR(normals[rig.mesh.source_vertex[v]].y, 1, 1e-6) << v;
}

// Two meshes whose bind spaces differ by one transform share their joints. The rest mesh is then in one space.
TEST(RigJoints, SkinsThatDifferByASpaceShareTheirJoints) {
    const Rig rig = readSample("two_skins");
    EXPECT_THAT(rig.skin.joint_names, ElementsAre("lower", "upper"));
    EXPECT_NEAR(boxDiagonal(rig.mesh.rest_positions), 1.2008, 1e-4);
    const double prism = 4 * 0.01 * std::sin(std::numbers::pi / 4);
    EXPECT_NEAR(volume(rig.mesh, posed(rig, -1, 0)), prism * (2 + 1.2 * 1.2 * 0.4), 1e-6);
}

TEST(RigFrames, AreAtMultiplesOfTheRateUpToTheEnd) {
    const Rig rig = readSample("bend");
    const FrameList frames = sampleFrames(rig, {"sway", "bend"}, 3);
    EXPECT_THAT(frames.clip_names, ElementsAre("sway", "bend"));
    EXPECT_THAT(frames.clip, ElementsAre(0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1));
    EXPECT_THAT(frames.time, testing::Contains(2.0).Times(2));
    EXPECT_DOUBLE_EQ(frames.time[1], 1.0 / 3);
}

TEST(RigFrames, HaveTheLastOneOfAClipWhoseEndIsAFloat) {
    const double end = double(23.0f / 24.0f);
    ASSERT_LT(end, 23.0 / 24);
    EXPECT_EQ(sampleClips({{"clip", 0, end, {}}}, {}, 24, "it").frameCount(), 24u);
}
TEST(RigFrames, WithoutARateAreTheKeysOfTheClip) {
    const Rig rig = readSample("interpolation");
    const FrameList frames = sampleFrames(rig, {"step"}, 0);
    EXPECT_THAT(frames.time, ElementsAre(0.25, 0.5, 1.0, 1.5));
    EXPECT_EQ(sampleFrames(readSample("bend"), {}, 0).frameCount(), 63u);
}

TEST(RigFrames, UnknownAndRepeatedClipsAndBadRatesAreUsageErrors) {
    const Rig rig = readSample("bend");
    try {
        sampleFrames(rig, {"jump"}, 0);
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), HasSubstr("'jump'"));
        EXPECT_THAT(error.what(), HasSubstr("bend, twist, sway"));
    }
    EXPECT_THROW(sampleFrames(rig, {"bend", "bend"}, 0), UsageError);
    EXPECT_THROW(sampleFrames(rig, {}, 1e9), UsageError);
}

}  // namespace
}  // namespace penumbra::test_rig_pose
