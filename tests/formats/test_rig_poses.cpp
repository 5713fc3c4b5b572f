// Tests poses as clips, and the glTF writer: what is written is read back as the same rig.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_poses.h"
#include "formats/source/source_readers.h"
#include "tests/difference.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_rig_poses {
namespace {

// Every synthetic rig, of every importer.
const std::vector<std::string> kRigs = {"bend.glb",         "capsule_man.glb", "influences8.glb",   "sparse.glb",
                                        "quantized.glb",    "props.glb",       "interpolation.glb", "two_skins.glb",
                                        "matrix_nodes.glb", "swing.x",         "swing.dae",         "swing.fbx",
                                        "swing_pivot.fbx",  "weights_u16.glb"};

std::vector<Vec3> positionsOf(const Rig& rig, int clip, double time) {
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, clip, time).bones, positions, normals);
    return positions;
}

// Returns the largest distance in diagonals of the first.
double distanceInDiagonals(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    return largestDistance(a, b) / boxDiagonal(a);
}

std::vector<RigFrame> someFrames(const Rig& rig) {
    std::vector<RigFrame> frames{{-1, 0}};
    for (std::size_t c = 0; c < rig.clips.size(); ++c)
        for (const double share : {0.0, 0.3, 0.77, 1.0}) frames.push_back({int(c), share * rig.clips[c].duration});
    return frames;
}

TEST(RigPoses, ClipOfFramesHasTheFramesAtWholeSeconds) {
    for (const std::string& name : kRigs) {
        Rig rig = samples::readAny(name);
        const std::vector<RigFrame> frames = someFrames(rig);
        const int poses = int(rig.clips.size());
        rig.clips.push_back(clipOfFrames(rig, frames, "poses"));
        const FrameList keys = sampleFrames(rig, {"poses"}, 0);
        ASSERT_EQ(keys.frameCount(), frames.size()) << name;
        for (std::size_t f = 0; f < frames.size(); ++f) {
            EXPECT_EQ(keys.time[f], double(f));
            // With STEP the pose stays until the next key. 2.7e-7 was measured, as keys are floats.
            for (const double later : {0.0, 0.9})
                EXPECT_LT(distanceInDiagonals(positionsOf(rig, frames[f].clip, frames[f].time),
                                              positionsOf(rig, poses, double(f) + later)),
                          1e-6)
                    << name << " frame " << f;
        }
    }
}

TEST(RigPoses, ClipOfRotationsTurnsTheJointsByTheseVectors) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> angle(-1.5f, 1.5f);
    for (const std::string& name : kRigs) {
        Rig rig = samples::readAny(name);
        for (Node& node : rig.nodes)  // a rest pose that is not the identity
            node.rotation = multiply(node.rotation, rotationOf({angle(random), angle(random), angle(random)}));
        const std::size_t width = 3 * rig.skin.jointCount();
        std::vector<float> rotations(4 * width);
        for (std::size_t i = width; i < rotations.size(); ++i)  // the first pose is the rest pose
            if (turnsItself(rig, i % width / 3)) rotations[i] = angle(random);
        const int poses = int(rig.clips.size());
        rig.clips.push_back(clipOfRotations(rig, rotations, "sampled"));
        EXPECT_LT(distanceInDiagonals(positionsOf(rig, -1, 0), positionsOf(rig, poses, 0)), 1e-6) << name;
        for (std::size_t p = 0; p < 4; ++p) {
            const std::vector<float> pose = evaluatePose(rig, poses, double(p)).pose;
            for (std::size_t i = 0; i < width; ++i) {
                if (!turnsItself(rig, i / 3)) continue;
                EXPECT_NEAR(pose[i], rotations[p * width + i], 2e-6) << name << " pose " << p << " number " << i;
            }
        }
    }
}

void expectSameRig(const Rig& a, const Rig& b, const std::string& name) {
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles) << name;
    EXPECT_EQ(a.mesh.source_vertex, b.mesh.source_vertex) << name;
    EXPECT_EQ(a.mesh.rest_positions, b.mesh.rest_positions) << name;
    EXPECT_EQ(a.skin.joint_names, b.skin.joint_names) << name;
    EXPECT_EQ(a.skin.parents, b.skin.parents) << name;
    EXPECT_EQ(a.skin.joints, b.skin.joints) << name;
    ASSERT_EQ(a.skin.weights.size(), b.skin.weights.size()) << name;
    // Weights are normalised again, which may change one unit in the last place.
    for (std::size_t i = 0; i < a.skin.weights.size(); ++i)
        EXPECT_NEAR(a.skin.weights[i], b.skin.weights[i], 1.2e-7) << name;
}

TEST(RigPoses, GlbIsReadBackAsTheSameRig) {
    const samples::Folder folder("glb");
    for (const std::string& name : kRigs) {
        Rig rig = samples::readAny(name);
        rig.clips = {clipOfFrames(rig, someFrames(rig), "poses")};
        const auto path = folder.path / (name + ".glb");
        writeGlb(path, rig, R"({"who":"test"})");
        const Rig back = readRig({path});
        expectSameRig(rig, back, name);
        ASSERT_EQ(back.clips.size(), 1u) << name;
        EXPECT_EQ(back.clips[0].name, "poses");
        EXPECT_EQ(back.clips[0].duration, rig.clips[0].duration);
        for (double t = 0; t <= rig.clips[0].duration; ++t) {
            // 3.0e-7 was measured, as inverse bind matrices become floats.
            EXPECT_LT(distanceInDiagonals(positionsOf(rig, 0, t), positionsOf(back, 0, t)), 1e-6) << name << ' ' << t;
            const std::vector<float> a = evaluatePose(rig, 0, t).pose, b = evaluatePose(back, 0, t).pose;
            ASSERT_EQ(a.size(), b.size());
            for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 2e-6) << name;
        }
    }
}

// A node that two joints share is written twice, since glTF allows a node only once in a skin.
TEST(RigPoses, JointsOfOneNodeStayTwoJoints) {
    const samples::Folder folder("shared");
    Rig rig = samples::readAny("bend.glb");
    const std::size_t second = rig.skin.jointCount();
    rig.skin.joint_names.push_back(rig.skin.joint_names[1] + "#2");
    rig.skin.parents.push_back(rig.skin.parents[1]);
    rig.node_of_joint.push_back(rig.node_of_joint[1]);
    rig.inverse_bind.push_back(rig.inverse_bind[1]);
    rig.inverse_bind.back()[3] += 0.25;
    for (std::size_t i = 0; i < rig.skin.joints.size(); i += 3)
        if (rig.skin.joints[i] == 1 && rig.skin.weights[i] > 0) rig.skin.joints[i] = std::uint16_t(second);
    EXPECT_FALSE(turnsItself(rig, second));
    rig.clips = {clipOfFrames(rig, someFrames(rig), "poses")};
    writeGlb(folder.path / "shared.glb", rig, "");
    const Rig back = readRig({folder.path / "shared.glb"});
    EXPECT_EQ(back.skin.joint_names, rig.skin.joint_names);
    EXPECT_EQ(back.skin.parents, rig.skin.parents);
    for (double t = 0; t <= rig.clips[0].duration; ++t)
        EXPECT_LT(distanceInDiagonals(positionsOf(rig, 0, t), positionsOf(back, 0, t)), 1e-6) << t;
}

// Reading turns triangles on joints that mirror at rest, so the writer must turn them first.
TEST(RigPoses, MirroredJointsKeepTheOutside) {
    const samples::Folder folder("mirror");
    Rig rig = samples::readAny("bend.glb");
    rig.nodes[std::size_t(rig.node_of_joint[0])].scale = {-1, 1, 1};
    rig.clips.clear();
    writeGlb(folder.path / "mirror.glb", rig, "");
    expectSameRig(rig, readRig({folder.path / "mirror.glb"}), "mirror");
}

TEST(RigPoses, SameGlbTwice) {
    const samples::Folder folder("bytes");
    const Rig rig = samples::readAny("capsule_man.glb");
    writeGlb(folder.path / "a.glb", rig, "{}");
    writeGlb(folder.path / "b.glb", rig, "{}");
    EXPECT_EQ(samples::bytesOf(folder.path / "a.glb"), samples::bytesOf(folder.path / "b.glb"));
    const Rig back = readRig({folder.path / "a.glb"});  // its own clips, LINEAR keys and all
    ASSERT_EQ(back.clips.size(), rig.clips.size());
    for (std::size_t c = 0; c < rig.clips.size(); ++c)
        EXPECT_LT(distanceInDiagonals(positionsOf(rig, int(c), 0.7), positionsOf(back, int(c), 0.7)), 1e-6);
}

}  // namespace
}  // namespace penumbra::test_rig_poses
