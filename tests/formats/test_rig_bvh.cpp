// Tests motion capture files: what they hold, how damaged ones are refused, and how they move a rig.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "tests/difference.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_bvh {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kBvh = R"(HIERARCHY
ROOT lower
{
	OFFSET 0 0 0
	CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
	JOINT Left Arm
	{
		OFFSET 0 50 0
		CHANNELS 4 Yposition Xrotation Zrotation Yrotation
		End Site
		{
			OFFSET 0 10 0
		}
	}
}
MOTION
Frames: 2
Frame Time: 0.25
0 0 0 0 0 0 50 0 0 0
1 2 3 90 0 90 60 90 90 0
)";

std::filesystem::path fileOf(const std::string& text, const std::string& name = "walk.bvh") {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
    samples::writeText(path, text);
    return path;
}

std::string refusalOf(const std::string& text) {
    try {
        readBvh(fileOf(text));
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "it was read";
}

void expectRotation(const Channel& channel, std::size_t key, const Quaternion& q) {
    const float* v = &channel.values[4 * key];
    const double sign = v[3] * q[3] < 0 ? -1 : 1;
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(sign * v[i], q[i], 1e-6) << "number " << i;
}

TEST(RigBvh, RotationsAreAppliedInTheOrderOfTheirChannels) {
    const RigSource source = readBvh(fileOf(kBvh));
    ASSERT_EQ(source.nodes.size(), 3u);
    EXPECT_EQ(source.nodes[1].name, "Left Arm");
    EXPECT_EQ(source.nodes[2].name, "Left Arm_end");
    EXPECT_THAT(source.nodes[2].translation, ElementsAre(0, 10, 0));
    ASSERT_EQ(source.clips.size(), 1u);
    EXPECT_EQ(source.clips[0].name, "walk");
    EXPECT_EQ(source.clips[0].duration, 0.25);
    const std::vector<Channel>& channels = source.clips[0].channels;
    ASSERT_EQ(channels.size(), 4u);
    EXPECT_THAT(channels[0].values, ElementsAre(0, 0, 0, 1, 2, 3));
    EXPECT_THAT(channels[2].values, ElementsAre(0, 50, 0, 0, 60, 0));  // the other axes are those of OFFSET
    const double half = std::numbers::sqrt2 / 2;
    const Quaternion x{half, 0, 0, half}, z{0, 0, half, half};
    expectRotation(channels[1], 1, multiply(z, x));
    expectRotation(channels[3], 1, multiply(x, z));
}

TEST(RigBvh, EveryTruncationIsRefused) {
    const std::size_t last_number = kBvh.find_last_of(' ') + 1;
    for (std::size_t n = 0; n < last_number; ++n)
        EXPECT_THAT(refusalOf(kBvh.substr(0, n)), HasSubstr("walk.bvh: ")) << n << " bytes";
    EXPECT_EQ(refusalOf(kBvh.substr(0, last_number + 1)), "it was read");
}

TEST(RigBvh, WrongFilesAreNamedByLine) {
    const auto changed = [](const std::string& from, const std::string& to) {
        std::string text = kBvh;
        return refusalOf(text.replace(text.find(from), from.size(), to));
    };
    EXPECT_THAT(changed("Zrotation", "Wrotation"), HasSubstr("line 5: 'wrotation' is not a channel"));
    EXPECT_THAT(changed("Zrotation", "Xrotation"), HasSubstr("channel 'xrotation' occurs twice"));
    EXPECT_THAT(changed("CHANNELS 6", "CHANNELS 7"), HasSubstr("line 5: a joint has 0 to 6 channels"));
    EXPECT_THAT(changed("Frames: 2", "Frames: 3"), HasSubstr("the file ends in frame 3 of 3"));
    EXPECT_THAT(changed("Frames: 2", "Frames: 1"), HasSubstr("values follow the last frame"));
    EXPECT_THAT(changed("Frames: 2", "Frames: 1e12"), HasSubstr("number of frames"));
    EXPECT_THAT(changed("0.25", "0"), HasSubstr("frame time"));
    EXPECT_THAT(changed("0.25", "nan"), HasSubstr("not finite"));
    EXPECT_THAT(changed("OFFSET 0 50", "OFFSET 0 5O"), HasSubstr("line 8: '5o' is not a number"));
    EXPECT_THAT(changed("OFFSET 0 50", "OFSET 0 50"), HasSubstr("line 8: 'ofset' is not known here"));
}

// The sample's joint "upper" stands 0.5 m above "lower", and the file counts centimetres.
TEST(RigBvh, MovesARigInAnotherUnit) {
    std::string text = kBvh;
    text.replace(text.find("Left Arm"), 8, "upper");
    const std::filesystem::path swing = samples::samplePath("swing");
    const Rig rig = readRig({swing, fileOf(text)});
    const std::size_t clip = rig.clips.size() - 1;
    EXPECT_EQ(rig.clips[clip].name, "walk");
    const Rig own = readRig({swing});
    const Vec3 joint = toFloat(transformPoint(restGlobals(own.nodes)[std::size_t(own.node_of_joint[1])], {0, 0, 0}));
    const Vec3 at = evaluatePose(rig, int(clip), 0).bones[1].point(joint);
    EXPECT_LT(length(at - joint), 1e-6f);
    const Vec3 root = evaluatePose(rig, int(clip), 0.25).bones[0].translation();
    EXPECT_LT(length(root - Vec3{.01f, .02f, .03f}), 1e-6f);
    EXPECT_THROW(readRig({fileOf(text)}), InvalidInput);
}

// The axes of a file on which those of the rig lie, and their signs. The default has y up, and {"XZY", {1, 1, -1}}
// has z up, as Blender writes it.
struct FileAxes {
    std::string letters = "XYZ";
    std::array<int, 3> signs{1, 1, 1};
};

std::string inAxes(const FileAxes& axes, const std::array<double, 3>& v) {
    std::array<double, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) out[std::size_t(axes.letters[i] - 'X')] = axes.signs[i] * v[i];
    return std::to_string(out[0]) + " " + std::to_string(out[1]) + " " + std::to_string(out[2]) + "\n";
}

// Writes the joints of a rig as BVH. Each has a turn about the rig's x, one about its y and one about its z.
struct BvhWriter {
    const Rig& rig;
    FileAxes axes;
    std::string text = "HIERARCHY\n", values = "";

    void add(int node, bool is_root) {
        const Node& joint = rig.nodes[std::size_t(node)];
        text += (is_root ? "ROOT " : "JOINT ") + joint.name + "\n{\nOFFSET " + inAxes(axes, joint.translation);
        text += is_root ? "CHANNELS 6 Xposition Yposition Zposition" : "CHANNELS 3";
        if (is_root) values += inAxes(axes, {0.3, 0.5, 0.7});
        for (std::size_t i = 0; i < 3; ++i) {
            text += std::string(" ") + axes.letters[i] + "rotation";
            values += " " + std::to_string(axes.signs[i] * (10 + 7 * ((node + int(i)) % 5)));
        }
        text += "\n";
        for (std::size_t n = 0; n < rig.nodes.size(); ++n)
            if (rig.nodes[n].parent == node) add(int(n), false);
        text += "}\n";
    }
};

Rig movedByBvh(const FileAxes& axes) {
    const Rig rig = samples::readSample("capsule_man");
    BvhWriter writer{rig, axes};
    writer.add(rig.node_of_joint[0], true);
    std::replace(writer.values.begin(), writer.values.end(), '\n', ' ');
    const std::string motion = "MOTION\nFrames: 1\nFrame Time: 0.04\n" + writer.values + "\n";
    return readRig({samples::samplePath("capsule_man"), fileOf(writer.text + motion, "axes.bvh")});
}

// Signs are such that the file is no mirror image.
TEST(RigBvh, AxesOfTheFileAreFoundByTheBones) {
    const Rig y_up = movedByBvh({});
    const int clip = int(y_up.clips.size()) - 1;
    const auto expected = evaluatePose(y_up, clip, 0);
    EXPECT_GT(length(expected.bones[0].translation()), 0.1f);
    const auto axesNote = [](const Rig& rig) {
        for (const RigNote& note : rig.notes)
            if (note.feature == "other axes") return note.effect;
        return std::string("none");
    };
    EXPECT_EQ(axesNote(y_up), "none");
    for (const auto& [axes, said] : {std::pair(FileAxes{"XZY", {1, 1, -1}}, "+x, +z, -y"),
                                     {FileAxes{"YXZ", {1, 1, -1}}, "+y, +x, -z"},
                                     {FileAxes{"XYZ", {-1, 1, -1}}, "-x, +y, -z"}}) {
        const Rig rig = movedByBvh(axes);
        EXPECT_THAT(axesNote(rig), HasSubstr(said));
        const auto pose = evaluatePose(rig, clip, 0);
        ASSERT_EQ(pose.bones.size(), expected.bones.size());
        for (std::size_t b = 0; b < pose.bones.size(); ++b)
            for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
                EXPECT_LT(length(pose.bones[b].point(p) - expected.bones[b].point(p)), 1e-5f) << axes.letters << b;
    }
}

// A chain on one line fits four turns of each kind, so that nothing tells which one is meant.
TEST(RigBvh, AxesThatTheBonesDoNotTellAreRefused) {
    std::string text = kBvh;
    text.replace(text.find("Left Arm"), 8, "upper");
    text.replace(text.find("0 50 0"), 6, "0 0 50");
    try {
        readRig({samples::samplePath("swing"), fileOf(text)});
        FAIL() << "it was read";
    } catch (const InvalidInput& error) {
        EXPECT_THAT(error.what(), HasSubstr("'upper' by 90 degrees"));
    }
}

}  // namespace
}  // namespace penumbra::test_rig_bvh
