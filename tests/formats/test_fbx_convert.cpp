// FBX files go through the converter where it is there and reads them right. A script stands in for it here; the tests
// of the real one are skipped where it is missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "formats/common/errors.h"
#include "formats/rig/fbx/fbx_convert.h"
#include "formats/rig/rig_import.h"
#include "tests/formats/fbx_samples.h"
#include "tests/formats/rig_samples.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_fbx_convert {
namespace {

namespace fs = std::filesystem;
using samples::FbxRig;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// Sets a variable of the environment for as long as it lives.
class Environment {
public:
    Environment(const char* name, const std::string& value) : name_(name) {
        if (const char* old = std::getenv(name)) old_ = old;
        ::setenv(name, value.c_str(), 1);
    }
    ~Environment() { old_ ? ::setenv(name_, old_->c_str(), 1) : ::unsetenv(name_); }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::optional<std::string> old_;
};

struct FbxConvert : testing::Test {
    samples::Folder folder{"fbx_convert"};
    fs::path fbx = folder.path / "a.fbx", glb = folder.path / "prepared.glb", program = folder.path / "converter";

    void SetUp() override {
        fs::create_directory(folder.path / "tmp");
        samples::writeText(fbx, samples::asciiFile(samples::turningRig(8).root));  // assimp reads this rig wrong
        samples::EditableGlb prepared = samples::EditableGlb::of("swing");
        prepared.json["animations"][0]["name"] = "turn";
        samples::writeText(glb, prepared.bytes());
    }
    // A converter that does `before`, copies the prepared .glb to OUT and says which frames it has, at 30 a second.
    void writeConverter(const std::string& before, const std::string& says = "Animation turn: [0 - 30]") {
        samples::writeText(program, "#!/bin/sh\nwhile [ \"$1\" != -o ]; do shift; done\nout=$2.glb\n" + before +
                                        "\ncp '" + glb.string() + "' \"$out\" 2>/dev/null\necho '" + says + "'\n");
        fs::permissions(program, fs::perms::owner_all);
    }
    std::string refusal() {
        try {
            read();
        } catch (const Unsupported& error) {
            return error.what();
        }
        return "it was read";
    }
    RigSource read() {
        const Environment converter("PENUMBRA_FBX2GLTF", program.string()),
            tmp("TMPDIR", (folder.path / "tmp").string());
        RigSource source = readFbx(fbx);
        EXPECT_TRUE(fs::is_empty(folder.path / "tmp"));
        return source;
    }
};

TEST_F(FbxConvert, WhatItMakesIsReadAsTheFile) {
    writeConverter("");
    const RigSource source = read();
    EXPECT_EQ(source.file, fbx);
    EXPECT_THAT(source.files_read, ElementsAre(fbx, program));
    ASSERT_EQ(source.clips.size(), 1u);
    EXPECT_NEAR(source.clips[0].duration, 1, 1e-6);  // length of its take
    ASSERT_TRUE(source.converted);
    EXPECT_EQ(source.converted->size(), fs::file_size(glb));
    EXPECT_THAT(source.log, ElementsAre(AllOf(HasSubstr(program.string()), HasSubstr("network"))));
    const Environment converter("PENUMBRA_FBX2GLTF", program.string());
    EXPECT_EQ(readRig({fbx}).converted, nullptr);
    RigOptions options;
    options.keep_converted = true;
    EXPECT_NE(readRig({fbx}, options).converted, nullptr);
    EXPECT_THAT(readRig({fbx}).files_read, ElementsAre(fbx, program));
}

// The clip of the prepared file is 1 s long: frames 15 to 45 of the timeline, of which the take shows 30 (1 s) to 60.
TEST_F(FbxConvert, ClipsAreCutToTheirTakes) {
    FbxRig rig;
    for (samples::FbxSample& p : rig.object("AnimationStack", FbxRig::kTake).children[0].children)
        p.values[4] = std::int64_t((std::get<std::string>(p.values[0]) == "LocalStop" ? 2 : 1) * FbxRig::kTicks);
    const samples::FbxNumbers times{0.5, 2.5};
    rig.curves(FbxRig::kLayer, FbxRig::kArm, "Lcl Rotation", {{times, {0, 90}}, {times, {0, 0}}, {times, {0, 0}}}, 8);
    samples::writeText(fbx, samples::asciiFile(rig.root));
    writeConverter("", "Animation turn: [15 - 45]");
    const RigSource cut = read();
    ASSERT_EQ(cut.clips.size(), 1u);
    EXPECT_NEAR(cut.clips[0].duration, 0.5, 1e-6);
    for (const Channel& channel : cut.clips[0].channels) EXPECT_EQ(channel.times.front(), 0);
}

TEST_F(FbxConvert, FailuresAreRefusedWithBothReasons) {
    const auto said = [&](const std::string& before) {
        writeConverter(before);
        return refusal();
    };
    const std::string assimp = "; assimp: clip 'turn': node 'arm': the curves of Lcl Rotation are not linear";
    EXPECT_THAT(said("kill -SEGV $$"),
                AllOf(StartsWith(fbx.string() + ": FBX2glTF: it crashed: signal 11"), HasSubstr(assimp)));
    EXPECT_THAT(said("echo no memory; exit 3"), HasSubstr("FBX2glTF: it ended with status 3: no memory; assimp: "));
    EXPECT_THAT(said("exit 0"), HasSubstr("its .glb is not whole"));
    EXPECT_THAT(said("head -c 300 '" + glb.string() + "' > \"$out\"; exit 0"), HasSubstr("its .glb is not whole"));
    samples::EditableGlb prepared = samples::EditableGlb::of("swing");
    samples::writeText(glb, prepared.bytes());
    EXPECT_THAT(said(""), HasSubstr("its .glb lacks the clip 'turn'"));
    for (const char* list : {"meshes", "animations", "skins", "nodes", "scenes"}) prepared.json.erase(list);
    samples::writeText(glb, prepared.bytes());
    EXPECT_THAT(said(""), HasSubstr("its .glb has no mesh, and the file has one that is shown"));
}

TEST_F(FbxConvert, AssimpReadsWhatItReadsRight) {
    samples::writeText(fbx, samples::asciiFile(samples::turningRig().root));
    writeConverter("exit 1");
    EXPECT_THAT(read().files_read, ElementsAre(fbx));
    const Environment off("PENUMBRA_FBX2GLTF", "off");
    EXPECT_EQ(readRig({fbx}).clips.size(), 1u);
}

TEST_F(FbxConvert, WithoutItTheCommandThatInstallsItIsTold) {
    program = "off";
    EXPECT_THAT(refusal(), AllOf(StartsWith(fbx.string() + ": assimp reads it wrong (clip 'turn': node 'arm': "),
                                 HasSubstr("`scripts/setup --fbx` installs it")));
    FbxRig compensating = samples::turningRig();
    for (samples::FbxSample& p : compensating.object("Model", FbxRig::kArm).children[0].children)
        if (std::get<std::string>(p.values[0]) == "InheritType") p.values[4] = std::int64_t(2);
    compensating.setProperty("Model", FbxRig::kRoot, FbxRig::property("Lcl Scaling", {2.0, 2.0, 2.0}));
    samples::writeText(fbx, samples::asciiFile(compensating.root));
    EXPECT_THAT(refusal(),
                AllOf(HasSubstr("FBX2glTF: node 'arm' does not inherit"), HasSubstr("; assimp: node 'arm'")));
    const Environment nowhere("PENUMBRA_FBX2GLTF", "/nowhere/FBX2glTF");
    EXPECT_THROW(readFbx(fbx), IoError);
}

// It has nothing to do with other folders, and nothing there changes where the kernel can see to it.
TEST_F(FbxConvert, WritesIntoItsOwnFolderAlone) {
    writeConverter("echo mine > mine; echo x > '" + (folder.path / "outside").string() + "'");
    const RigSource source = read();
    EXPECT_EQ(fs::exists(folder.path / "outside"), source.log.at(0).find("one folder") == std::string::npos);
}

// The converter divides by the sum of no weights.
TEST_F(FbxConvert, VerticesWithoutBoneStayWithTheirNode) {
    samples::EditableGlb prepared = samples::EditableGlb::of("swing");
    prepared.json["animations"][0]["name"] = "turn";
    const int accessor = prepared.attributes()["WEIGHTS_0"];
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (int k = 0; k < 4; ++k) std::memcpy(prepared.binary.data() + prepared.offsetOf(accessor) + 4 * k, &nan, 4);
    samples::writeText(glb, prepared.bytes());
    writeConverter("");
    const RigSource source = read();
    const SourcePart& part = source.parts.at(0);
    const SourceSkin& skin = source.skins.at(std::size_t(part.skin));
    EXPECT_EQ(part.weights.at(0), 1);
    EXPECT_EQ(skin.nodes.at(part.joints.at(0)), part.node);
    EXPECT_EQ(skin.inverse_bind.at(part.joints.at(0)), kIdentityMatrix);
}

// --- The real converter ---------------------------------------------------------------------------------------------

struct FbxRealConverter : FbxConvert {
    void SetUp() override {
        FbxConvert::SetUp();
        const char* real = std::getenv("PENUMBRA_TEST_FBX2GLTF");
        if (!real) GTEST_SKIP() << "PENUMBRA_TEST_FBX2GLTF does not name FBX2glTF";
        program = real;
    }
    // How far the top of the tube has turned in the middle of the clip, in degrees.
    double turnAt(double time) {
        const Environment converter("PENUMBRA_FBX2GLTF", program.string());
        const Rig rig = readRig({fbx});
        std::vector<Vec3> positions, normals;
        skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, 0, time).bones, positions, normals);
        Vec3 top{};
        for (std::size_t v = 0; v < positions.size(); ++v)
            if (rig.mesh.rest_positions[v].y > 0.5) top = top + positions[v];
        return std::atan2(-top.x, top.y - 6 * 0.3f) * 180 / std::numbers::pi;
    }
};

TEST_F(FbxRealConverter, ReadsCurvesPivotsAndLayers) {
    EXPECT_NEAR(turnAt(1.0 / 3), 90 * (3 / 9.0 - 2 / 27.0), 0.2);  // cubic, with flat tangents
    FbxRig rig = samples::turningRig();
    rig.layer(402, FbxRig::kTake);
    const samples::FbxNumbers ends{0, 1};
    rig.curves(402, FbxRig::kArm, "Lcl Rotation", {{ends, {0, 0}}, {ends, {0, 0}}, {ends, {-30, -30}}});
    samples::writeText(fbx, samples::asciiFile(rig.root));
    EXPECT_NEAR(turnAt(0.5), 15, 0.1);
}

}  // namespace
}  // namespace penumbra::test_fbx_convert
