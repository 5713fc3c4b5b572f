// Clips of other files move a rig as they move their own skeleton, whatever its names, unit, axes and nodes between
// joints are. Rest poses that do not fit are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_names.h"
#include "tests/difference.h"

namespace penumbra::test_rig_clips {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int kJoints = 6;
const char* const kNames[kJoints] = {"Hips", "Spine", "LeftArm", "LeftHand", "RightArm", "RightHand"};
constexpr int kParents[kJoints] = {-1, 0, 1, 2, 1, 4};
const Vec3d kOffsets[kJoints] = {{0, 1, .1}, {0, .5, 0}, {.2, .2, 0}, {.4, 0, 0}, {-.2, .2, 0}, {-.4, 0, 0}};

// How a skeleton states the same joints.
struct Shape {
    std::string prefix = "";
    double size = 1;                            // its lengths, over those of kOffsets
    Quaternion axes[kJoints] = {};              // rotation of each joint's axes; 0: none
    std::array<double, 3> node_scale{1, 1, 1};  // scale of a node above the hips
    Quaternion node_rotation{0, 0, 0, 1};
};

Quaternion turn(Vec3d axis, double degrees) { return rotationOf(axis * (degrees / 57.29577951308232 / length(axis))); }

Quaternion axesOf(const Shape& shape, int joint) {
    if (joint < 0) return {0, 0, 0, 1};
    return normalized(shape.axes[joint]).value_or(Quaternion{0, 0, 0, 1});
}

// Returns a joint's position in the axes of its parent, or of the node above the hips.
Vec3d placed(const Shape& shape, int joint, Vec3d p) {
    const Quaternion back = conjugate(kParents[joint] < 0 ? shape.node_rotation : axesOf(shape, kParents[joint]));
    const double size = shape.size / (kParents[joint] < 0 ? shape.node_scale[0] : 1);
    return transformPoint(composeTransform({}, back, {size, size, size}), p);
}

Quaternion rotated(const Shape& shape, int joint, const Quaternion& q) {
    const Quaternion back = conjugate(kParents[joint] < 0 ? shape.node_rotation : axesOf(shape, kParents[joint]));
    return multiply(back, multiply(q, axesOf(shape, joint)));
}

// Node 0 stands above the hips, and node 1 + j is joint j. Lengths below a scaled node are written unscaled.
RigSource skeletonOf(const Shape& shape) {
    RigSource source;
    source.file = shape.prefix + "rig.glb";
    Node& above = source.nodes.emplace_back();
    above.name = "Armature";
    above.rotation = shape.node_rotation;
    above.scale = shape.node_scale;
    for (int j = 0; j < kJoints; ++j) {
        Node& node = source.nodes.emplace_back();
        node.name = shape.prefix + kNames[j];
        node.parent = 1 + kParents[j];
        const Vec3d p = placed(shape, j, kOffsets[j]) / (j > 0 ? shape.node_scale[0] : 1);
        node.translation = {p.x, p.y, p.z};
        node.rotation = rotated(shape, j, {0, 0, 0, 1});
    }
    return source;
}

// A triangle hangs on each joint.
void addMesh(RigSource& source) {
    const std::vector<Matrix> globals = restGlobals(source.nodes);
    SourceSkin& skin = source.skins.emplace_back();
    SourcePart& part = source.parts.emplace_back();
    part.skin = 0;
    part.influences = 1;
    for (int j = 0; j < kJoints; ++j) {
        const Matrix& m = globals[std::size_t(1 + j)];
        skin.nodes.push_back(1 + j);
        skin.inverse_bind.push_back(*inverse(m));
        for (const Vec3 corner : {Vec3{.1f, 0, 0}, {0, .1f, 0}, {0, 0, .1f}}) {
            part.positions.push_back(Vec3{float(m[3]), float(m[7]), float(m[11])} + corner);
            part.joints.push_back(std::uint32_t(j));
            part.weights.push_back(1);
        }
        const std::uint32_t v = std::uint32_t(3 * j);
        part.triangles.push_back({v, v + 1, v + 2});
    }
}

// Every joint turns, and the hips go, in two keys.
RigSource clipOf(const Shape& shape) {
    RigSource source = skeletonOf(shape);
    source.file = shape.prefix + "clip.glb";
    Clip& clip = source.clips.emplace_back();
    clip.name = "walk";
    clip.duration = 1;
    for (int j = 0; j < kJoints; ++j) {
        Channel channel{1 + j, Channel::Path::kRotation, Interpolation::kLinear, {0, 1}, {}};
        for (const double degrees : {40.0, 5.0})
            for (const double v : rotated(shape, j, turn({1, double(j), 2 - double(j)}, degrees)))
                channel.values.push_back(float(v));
        clip.channels.push_back(channel);
    }
    Channel hips{1, Channel::Path::kTranslation, Interpolation::kLinear, {0, 1}, {}};
    for (const Vec3d p : {kOffsets[0], Vec3d{.3, 1.2, -.5}}) {
        const Vec3d at = placed(shape, 0, p);
        for (const double v : {at.x, at.y, at.z}) hips.values.push_back(float(v));
    }
    clip.channels.push_back(hips);
    return source;
}

std::vector<Vec3> posedBy(const Shape& of_rig, RigSource clip, std::vector<RigNote>* notes = nullptr) {
    RigSource rig = skeletonOf(of_rig);
    addMesh(rig);
    const Rig joined = joinRig({std::move(rig), std::move(clip)}, {});
    if (notes) *notes = joined.notes;
    std::vector<Vec3> all, positions, normals;
    for (const double time : {0.0, 0.4, 1.0}) {
        skinVertices(joined.mesh, joined.skin, joined.rest_normals, evaluatePose(joined, 0, time).bones, positions,
                     normals);
        all.insert(all.end(), positions.begin(), positions.end());
    }
    return all;
}

std::string refusalOf(const Shape& of_rig, RigSource clip) {
    try {
        posedBy(of_rig, std::move(clip));
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "it was read";
}

// Keys are floats: 2e-6 is a few roundings of numbers near 1.
TEST(RigClips, OtherUnitsAxesAndNodesMoveTheRigAsItsOwnClip) {
    const std::vector<Vec3> expected = posedBy({}, clipOf({}));
    Shape centimetres{.size = 100}, axes{}, node{};
    for (int j = 0; j < kJoints; ++j) axes.axes[j] = turn({double(j) - 2, 1, .5}, 20.0 * j + 30);
    node.node_scale = {.01, .01, .01};
    node.node_rotation = turn({1, 0, 0}, -90);
    for (const Shape& other : {centimetres, axes, node}) {
        EXPECT_LT(largestDistance(expected, posedBy({}, clipOf(other))), 2e-6);
        Shape rig = other;
        rig.size = 1;
        EXPECT_LT(largestDistance(posedBy(rig, clipOf(rig)), posedBy(rig, clipOf({}))), 2e-6);
    }
}

TEST(RigClips, NamesMatchWithoutNamespacesAndPrefixes) {
    const std::vector<Vec3> expected = posedBy({}, clipOf({}));
    for (const char* prefix : {"mixamorig:", "mixamorig_", "mixamorig", "Bip01 ", "Armature|", "a:b:Rig1_"}) {
        std::vector<RigNote> notes;
        EXPECT_EQ(largestDistance(expected, posedBy({}, clipOf({.prefix = prefix}), &notes)), 0) << prefix;
        ASSERT_THAT(notes, SizeIs(1)) << prefix;
        EXPECT_THAT(textOf(notes[0]), HasSubstr(std::string(prefix) + "Hips' moves 'Hips'"));
        EXPECT_EQ(largestDistance(expected, posedBy({.prefix = prefix}, clipOf({.prefix = "x:"}))), 0) << prefix;
    }
}

TEST(RigNames, TheLongestPrefixThatMatchesMostGoes) {
    const auto match = [](std::vector<std::string> targets, std::vector<std::string> sources) {
        return matchNames(targets, sources);
    };
    // Half of a file's names begin with "Left", and no prefix takes that away.
    EXPECT_THAT(match({"LeftArm", "LeftLeg", "Head"}, {"rig_LeftArm", "rig_LeftLeg", "rig_Head"}),
                ElementsAre(0, 1, 2));
    EXPECT_THAT(match({"Bip001", "Bip001 Head"}, {"Bip01", "Bip01 Head"}), ElementsAre(0, 1));
    EXPECT_THAT(match({"arm.L", "arm.R"}, {"arm_R", "arm_L"}), ElementsAre(1, 0));
    // Each skeleton has its own source where there are as many, else all have the first.
    EXPECT_THAT(match({"Hips", "Hips"}, {"Hips", "Hips"}), ElementsAre(0, 1));
    EXPECT_THAT(match({"Hips", "b:Hips", "Toe"}, {"Hips"}), ElementsAre(0, 0, -1));
}

TEST(RigClips, RestPosesThatAreTurnedAreRefusedByJoint) {
    Shape bent{};
    bent.axes[3] = turn({0, 0, 1}, 25);  // a hand, on which nothing hangs that tells its axes
    RigSource clip = clipOf(bent);
    EXPECT_THAT(refusalOf({}, clip), HasSubstr("these joints are turned: 'LeftHand' by 25 degrees"));
    // The same axes, but the arm hangs down.
    clip = clipOf({});
    clip.nodes[4].translation = {0, -.4, 0};
    EXPECT_THAT(refusalOf({}, clip), HasSubstr("the bones before these joints are turned: 'LeftHand' by 90 degrees"));
}

// A clip without a skin often stands in its first frame, and the joints' axes are known by their children.
TEST(RigClips, NodesThatStandInTheFirstFrameAreNoRestPose) {
    RigSource clip = clipOf({});
    for (int j = 1; j < kJoints; ++j)
        for (std::size_t i = 0; i < 4; ++i)
            clip.nodes[std::size_t(1 + j)].rotation[i] = clip.clips[0].channels[std::size_t(j)].values[i];
    std::vector<RigNote> notes;
    EXPECT_LT(largestDistance(posedBy({}, clipOf({})), posedBy({}, clip, &notes)), 2e-6);
    ASSERT_THAT(notes, SizeIs(1));
    EXPECT_THAT(textOf(notes[0]), HasSubstr("its nodes stand in the first frame of a clip"));
}

TEST(RigClips, WhatMovesNothingIsListedAndTooMuchOfItIsRefused) {
    RigSource clip = clipOf({});
    clip.nodes[6].name = "Tail";
    std::vector<RigNote> notes;
    posedBy({}, clip, &notes);
    ASSERT_THAT(notes, SizeIs(2));
    EXPECT_THAT(textOf(notes[0]), HasSubstr("clip.glb: channels of 'Tail': move nothing"));
    EXPECT_THAT(textOf(notes[1]), HasSubstr("'RightHand' stay as at rest"));
    for (std::size_t n = 3; n < 7; ++n) clip.nodes[n].name = "bone" + std::to_string(n);
    EXPECT_THAT(refusalOf({}, clip), HasSubstr("4 of the 6 nodes that its clips move are not in rig.glb: 'bone3', "));
    clip.clips.clear();
    EXPECT_THAT(refusalOf({}, clip), HasSubstr("brings no clip"));
}

TEST(RigClips, MatricesAreDecomposedAndShearIsRefused) {
    const auto withMatrix = [](double shear) {
        RigSource rig = skeletonOf({});
        addMesh(rig);
        const Matrix m = restTransform(rig.nodes[2]);
        rig.nodes[2].matrix = {m[0], m[4], m[8],  0, m[1] + shear, m[5], m[9],  0,
                               m[2], m[6], m[10], 0, m[3],         m[7], m[11], 1};
        return rig;
    };
    const Rig rig = joinRig({withMatrix(0), clipOf({})}, {});
    EXPECT_FALSE(rig.nodes[2].matrix);
    EXPECT_THROW(joinRig({withMatrix(.1), clipOf({})}, {}), InvalidInput);
}

// Two skeletons of one name both move.
TEST(RigClips, AChannelMovesEveryJointOfItsName) {
    RigSource rig = skeletonOf({});
    const std::size_t nodes = rig.nodes.size();
    for (std::size_t n = 0; n < nodes; ++n) {
        Node copy = rig.nodes[n];
        if (copy.parent >= 0) copy.parent += int(nodes);
        rig.nodes.push_back(copy);
    }
    addMesh(rig);
    rig.skins.push_back(rig.skins[0]);
    for (int& n : rig.skins[1].nodes) n += int(nodes);
    rig.parts.push_back(rig.parts[0]);
    rig.parts[1].skin = 1;
    const Rig joined = joinRig({std::move(rig), clipOf({})}, {});
    EXPECT_THAT(joined.clips[0].channels, SizeIs(2 * (kJoints + 1)));
}

// --- Times ----------------------------------------------------------------------------------------------------------

RigSource withTimes(double first, double last) {
    RigSource rig = clipOf({});
    addMesh(rig);
    for (Channel& channel : rig.clips[0].channels) channel.times = {first, last};
    rig.clips[0].duration = last;
    return rig;
}

TEST(RigClipTimes, LateStartsAreTrimmedOrSaid) {
    const Rig late = joinRig({withTimes(10, 11)}, {});
    EXPECT_EQ(late.clips[0].duration, 1);
    EXPECT_THAT(late.clips[0].channels[0].times, ElementsAre(0, 1));
    ASSERT_THAT(late.notes, SizeIs(1));
    EXPECT_THAT(textOf(late.notes[0]), HasSubstr("clip 'walk': would stand still up to its first key at 10 s"));
    const Rig said = joinRig({withTimes(.6, 2)}, {});
    EXPECT_EQ(said.clips[0].duration, 2);
    ASSERT_THAT(said.notes, SizeIs(1));
    EXPECT_THAT(textOf(said.notes[0]), HasSubstr("stands still up to its first key at 0.6 s"));
    EXPECT_THAT(joinRig({withTimes(1.0 / 24, 2)}, {}).notes, SizeIs(0));
}

TEST(RigClipTimes, ClipsOfACameraAreLeftOut) {
    RigSource rig = withTimes(0, 1);
    Node& camera = rig.nodes.emplace_back();
    camera.name = "camera";
    rig.clips.push_back(
        {"shot",
         1,
         {{int(rig.nodes.size()) - 1, Channel::Path::kTranslation, Interpolation::kLinear, {0}, {1, 2, 3}}}});
    const Rig joined = joinRig({std::move(rig)}, {});
    EXPECT_THAT(joined.clips, SizeIs(1));
    ASSERT_THAT(joined.notes, SizeIs(1));
    EXPECT_THAT(textOf(joined.notes[0]), HasSubstr("clip 'shot': moves nothing that is drawn"));
}

}  // namespace
}  // namespace penumbra::test_rig_clips
