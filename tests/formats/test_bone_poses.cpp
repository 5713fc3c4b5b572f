// x.poses.json: poses come back bit for bit, and what is no such file, or of another rig, is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "formats/common/errors.h"
#include "formats/scene/bone_poses.h"

namespace penumbra::test_bone_poses {
namespace {

using ::testing::HasSubstr;

BonePoses twoPoses() {
    BonePoses poses{{"hip", "knee"}, {}};
    for (int i = 0; i < 2; ++i) {
        const float x = 0.1f + float(i);
        poses.poses.push_back(
            {"walk", 0.1 * i, {Affine{}, Affine{{1, 0, 0, x, 0, 1, 0, -x / 3, 0, 0, 1, 1e-20f}}}, {}});
        poses.poses.back().rotations = {0, x / 7, 0, -x, 3, 0};
    }
    return poses;
}

TEST(BonePoses, ComeBackBitForBit) {
    const BonePoses written = twoPoses(), read = parseBonePoses(bonePosesText(written), "p.json");
    EXPECT_EQ(read.joint_names, written.joint_names);
    ASSERT_EQ(read.poses.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(read.poses[i].clip, "walk");
        EXPECT_EQ(read.poses[i].time, written.poses[i].time);
        EXPECT_EQ(read.poses[i].bones, written.poses[i].bones);
        EXPECT_EQ(read.poses[i].rotations, written.poses[i].rotations);
    }
}

std::string problemOf(const std::string& text) {
    try {
        (void)parseBonePoses(text, "p.json");
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(BonePoses, RefuseWithThePlace) {
    const auto with = [](const std::string& joints, const std::string& poses) {
        return R"({"format": "penumbra.bone_poses", "version": 1, "joints": )" + joints + R"(, "poses": )" + poses +
               "}";
    };
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "p.json: not JSON"},
        {"{}", "p.json: /: has no \"format\""},
        {R"({"format": "penumbra.poses"})", "p.json: /format: is \"penumbra.poses\", and not \"penumbra.bone_poses\""},
        {R"({"format": "penumbra.bone_poses", "version": 2, "bones": []})",
         "p.json: /version: is version 2 of penumbra.bone_poses, and this build reads version 1 alone: make"},
        {R"({"format": "penumbra.bone_poses"})", "p.json: /: has no \"version\""},
        {R"({"format": "penumbra.bone_poses", "version": 1})", "p.json: /: has no \"joints\""},
        {R"({"format": "penumbra.bone_poses", "version": 1, "joints": ["a"]})", "p.json: /: has no \"poses\""},
        {with("[]", "[]"), "p.json: /joints: is empty"},
        {with(R"(["a"])", "[]"), "p.json: /poses: is empty"},
        {with(R"(["a"])", "[{}]"), "p.json: /poses/0: has no \"bones\""},
        {with(R"(["a"])", R"([{"bones": []}])"), "p.json: /poses/0/bones: must have 1 rows, one a joint"},
        {with(R"(["a"])", R"([{"bones": [[1, 2]]}])"), "p.json: /poses/0/bones/0: must have 12 numbers"},
        {with(R"(["a"])", R"([{"bones": [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, null, 0]]}])"),
         "p.json: /poses/0/bones/0/10: must be a number"},
        {with(R"(["a"])", R"([{"bones": [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]]}])"),
         "p.json: /poses/0: has no \"rotations\""},
        {with(R"(["a"])", R"([{"bone": []}])"), "p.json: /poses/0/bone: unknown key"},
    };
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(text), HasSubstr(expected)) << text;
}

TEST(BonePoses, AreOfOneRig) {
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "penumbra_two.poses.json";
    std::ofstream(file) << bonePosesText(twoPoses());
    SceneCharacter one;
    one.asset = "a.pnb";
    one.pose = {"s.json: /characters/0/pose", file, 1};
    AssetView asset;
    asset.animation.joint_names = {"hip", "knee"};
    asset.animation.pose_size = 6;
    asset.model.features = FeatureKind::kJointAngles;
    PoseFiles files;
    EXPECT_EQ(files.poseOf(one, asset).bones, twoPoses().poses[1].bones);
    const auto refused = [&](const std::string& what) {
        try {
            (void)files.poseOf(one, asset);
            ADD_FAILURE() << what;
        } catch (const InvalidInput& problem) {
            EXPECT_THAT(problem.what(), HasSubstr("s.json: /characters/0/pose: "));
            EXPECT_THAT(problem.what(), HasSubstr(what));
        }
    };
    one.pose->frame = 2;
    refused("has 2 poses, so none of number 2");
    asset.animation.joint_names = {"hip", "foot"};
    refused("its joint 1 is \"knee\", and that of a.pnb is \"foot\"");
    asset.animation.joint_names = {"hip"};
    refused("has 2 joints, and a.pnb has 1");
    asset.animation.joint_names = {"hip", "knee"};
    asset.animation.pose_size = 7;
    refused("no other numbers than joint rotations");
    asset.model.deforming = true;
    refused("a.pnb is a cloth");
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace penumbra::test_bone_poses
