#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "formats/common/errors.h"
#include "formats/stage/pose_file.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_pose_file {
namespace {

TEST(PoseFile, RoundTripIsExactAndDeterministic) {
    const PoseFile poses = samples::poseFile(), back = samples::roundTrip(poses, writePoseFile, readPoseFile);
    EXPECT_EQ(back.frames.clip_names, poses.frames.clip_names);
    EXPECT_EQ(back.frames.clip, poses.frames.clip);
    EXPECT_EQ(back.frames.time, poses.frames.time);
    EXPECT_EQ(back.rank, poses.rank);
    EXPECT_EQ(back.distance, poses.distance);
    EXPECT_EQ(back.joint_names, poses.joint_names);
    EXPECT_EQ(back.rotations, poses.rotations);
    EXPECT_EQ(back.sampledCount(), 2u);
    EXPECT_EQ(toJson(back.provenance), toJson(poses.provenance));
}

TEST(PoseFile, MixedPosesMakeVersion2AndComeBack) {
    const PoseFile poses = samples::mixedPoseFile();
    EXPECT_EQ(poses.mixedCount(), 2u);
    const PoseFile back = samples::roundTrip(poses, writePoseFile, readPoseFile);
    EXPECT_EQ(back.frames.clip_names, poses.frames.clip_names);
    EXPECT_EQ(back.node_names, poses.node_names);
    EXPECT_EQ(back.mixed, poses.mixed);
    EXPECT_EQ(back.rotations, poses.rotations);
}

TEST(PoseFile, WithoutSampledPosesThereIsNoTableOfThem) {
    PoseFile poses = samples::poseFile();
    poses.frames = {{"walk", "run"}, {0, 0, 1}, {0, 0.5, 0}};
    poses.rank = {2, 0, 1};
    poses.distance = {0.5, 0, 1};
    poses.rotations.clear();
    EXPECT_EQ(samples::roundTrip(poses, writePoseFile, readPoseFile).sampledCount(), 0u);
}

// Each list is wrong in one field, which the message names.
TEST(PoseFile, WrongListsAreRefused) {
    struct Case {
        const char* field;
        std::function<void(PoseFile&)> damage;
    };
    const std::vector<Case> cases = {
        {"/frames/rank", [](PoseFile& p) { p.rank[1] = 3; }},
        {"/frames/rank", [](PoseFile& p) { p.rank[1] = 7; }},
        {"/frames/distance", [](PoseFile& p) { p.distance[2] = -0.5; }},
        {"/frames/time", [](PoseFile& p) { p.frames.time[1] = 0; }},
        {"/frames/time", [](PoseFile& p) { p.frames.time[0] = -1; }},
        {"/frames/time", [](PoseFile& p) { p.frames.time[6] = 1.5; }},
        {"/clips/names", [](PoseFile& p) { p.frames.clip[3] = p.frames.clip[4] = 2; }},
        {"/clips/names", [](PoseFile& p) { p.frames.clip_names[1] = "walk"; }},
        {"/clips/names", [](PoseFile& p) { p.frames.clip_names.push_back("unused"); }},
        {"/sampled/pose", [](PoseFile& p) { p.rotations.resize(6); }},
        {"/sampled/pose", [](PoseFile& p) { p.frames.clip_names[2] = "jump"; }},
        {"/skin/joint_names", [](PoseFile& p) { p.joint_names[1] = "root"; }},
        {"/mixed/nodes", [](PoseFile& p) { p.mixed.resize(30); }},
        {"/mixed/nodes", [](PoseFile& p) { p.node_names.pop_back(); }},
        {"/mixed/nodes", [](PoseFile& p) { p.mixed[33] *= 1.5f; }},
        {"/mixed/nodes", [](PoseFile& p) { std::fill_n(p.mixed.begin() + 43, 4, 0.0f); }},
        {"/mixed/nodes", [](PoseFile& p) { p.frames.clip_names[3] = "jump"; }},
        {"/frames/time", [](PoseFile& p) { p.frames.time[8] = 2; }},
    };
    const samples::Folder folder("wrong");
    for (const Case& c : cases) {
        PoseFile poses = samples::mixedPoseFile();
        c.damage(poses);
        writePoseFile(folder.path / "x.poses.h5", poses);
        try {
            readPoseFile(folder.path / "x.poses.h5");
            ADD_FAILURE() << c.field << " was accepted";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("x.poses.h5: ")) << c.field;
            EXPECT_THAT(error.what(), testing::HasSubstr(c.field));
        }
    }
}

}  // namespace
}  // namespace penumbra::test_pose_file
