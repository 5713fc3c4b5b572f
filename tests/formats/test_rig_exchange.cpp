// Reads the same rig and clip as glTF, DirectX .x (left-handed), Collada and FBX (z up, centimetres).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/difference.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_exchange {
namespace {

using testing::HasSubstr;

struct Pose {
    std::vector<Vec3> positions, normals;
};

Pose posed(const Rig& rig, int clip, double time) {
    Pose pose;
    const RigPose bones = evaluatePose(rig, clip, time);
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, bones.bones, pose.positions, pose.normals);
    return pose;
}

// Returns the largest distance from a point of `a` to the nearest of `b`, positions and normals together.
double farthest(const Pose& a, const Pose& b) {
    Largest worst;
    for (std::size_t i = 0; i < a.positions.size(); ++i) {
        double nearest = std::numeric_limits<double>::max();
        for (std::size_t k = 0; k < b.positions.size(); ++k)
            nearest = std::min(nearest,
                               double(length(a.positions[i] - b.positions[k]) + length(a.normals[i] - b.normals[k])));
        worst.add(nearest);
    }
    return worst;
}

class RigExchange : public testing::TestWithParam<std::string> {};

// 5e-7 was measured, as text has 9 digits and assimp uses floats. Normals tell that the outside is outside in every
// format.
TEST_P(RigExchange, GivesTheSamePosesAsGltf) {
    const Rig gltf = samples::readSample("swing");
    const Rig other = samples::readAny(GetParam());
    EXPECT_EQ(other.mesh.vertexCount(), gltf.mesh.vertexCount());
    EXPECT_EQ(other.mesh.triangles.size(), gltf.mesh.triangles.size());
    EXPECT_THAT(other.skin.joint_names, testing::UnorderedElementsAre("lower", "upper"));
    ASSERT_EQ(other.clips.size(), 1u);
    EXPECT_NEAR(other.clips[0].duration, 1, 1e-6);
    for (const double time : {0.0, 0.2, 0.37, 0.6, 0.85, 1.0}) {
        EXPECT_LT(farthest(posed(gltf, 0, time), posed(other, 0, time)), 5e-6) << time << " s";
        EXPECT_LT(farthest(posed(other, 0, time), posed(gltf, 0, time)), 5e-6) << time << " s";
    }
}

// swing_pivot.fbx turns about a pivot, for which assimp writes tracks of several links.
INSTANTIATE_TEST_SUITE_P(Formats, RigExchange, testing::Values("swing.x", "swing.dae", "swing.fbx", "swing_pivot.fbx"),
                         [](const auto& file) {
                             std::string name = file.param;
                             std::replace(name.begin(), name.end(), '.', '_');
                             return name;
                         });

TEST(RigFiles, LaterFilesBringTheirClipsByName) {
    const std::filesystem::path glb = samples::samplePath("swing"),
                                fbx = std::filesystem::path(glb).replace_extension(".fbx");
    const Rig rig = readRig({glb, samples::samplePath("bend"), fbx});
    std::vector<std::string> names;
    for (const Clip& clip : rig.clips) names.push_back(clip.name);
    EXPECT_THAT(names, testing::ElementsAre("swing", "bend", "twist", "sway", "swing#2"));
    EXPECT_EQ(rig.mesh.source_vertex.size(), 74u);
    EXPECT_EQ(rig.files_read.size(), 3u);
    // The FBX file is z up and in centimetres, and its joints have other axes. The bound is that of the test above.
    for (const double time : {0.0, 0.37, 1.0})
        EXPECT_LT(largestDistance(posed(rig, 0, time).positions, posed(rig, 4, time).positions), 5e-6) << time << " s";
    EXPECT_THROW(readRig({glb, samples::samplePath("capsule_man")}), InvalidInput);
}

// There is a part for each node and material. What has no material, or one without a name, is named so.
TEST(RigFiles, SlotsAreNamedAfterNodeAndMaterial) {
    samples::EditableGlb glb = samples::EditableGlb::of("swing");
    auto& primitives = glb.json["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    primitives.push_back(primitives[0]);
    primitives[0]["material"] = 1;
    primitives[1]["material"] = 0;
    primitives[2].erase("material");
    glb.json["materials"] = {nlohmann::json::object(), {{"name", "steel"}}};
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "slots.glb";
    samples::writeText(path, glb.bytes());
    const Rig rig = readRig({path});
    ASSERT_EQ(rig.mesh.slots.size() % 3, 0u);
    for (std::size_t i = 0; i < rig.mesh.slots.size(); ++i)
        EXPECT_THAT(rig.mesh.slots[i], testing::EndsWith(std::array{"/steel", "/material0", "/default"}[i % 3]));
    // The copies lie on the first part, and each slot has points of its own there.
    std::array<std::size_t, 3> points{};
    for (const std::uint16_t slot : rig.mesh.slot_of_vertex) ++points[slot % 3];
    EXPECT_EQ(points[0], rig.mesh.vertexCount() / 3);
    EXPECT_EQ(points[1], points[0]);
    EXPECT_EQ(points[2], points[0]);
}

TEST(RigFiles, UnknownKindsMissingFilesAndFolders) {
    EXPECT_THROW(readRig({"rig.obj"}), Unsupported);
    for (const char* extension : {".glb", ".gltf", ".fbx", ".dae", ".x"}) {
        EXPECT_THROW(readRig({std::string("missing") + extension}), IoError) << extension;
        const std::filesystem::path folder =
            std::filesystem::path(testing::TempDir()) / (std::string("folder") + extension);
        std::filesystem::create_directories(folder);
        EXPECT_THROW(readRig({folder}), IoError) << extension;
        const std::filesystem::path empty =
            std::filesystem::path(testing::TempDir()) / (std::string("empty") + extension);
        samples::writeText(empty, "");
        EXPECT_THROW(readRig({empty}), InvalidInput) << extension;
        samples::writeText(empty, "nonsense");
        EXPECT_THROW(readRig({empty}), InvalidInput) << extension;
    }
}

}  // namespace
}  // namespace penumbra::test_rig_exchange
