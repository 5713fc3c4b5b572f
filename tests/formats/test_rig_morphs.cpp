// Tests morph targets of rigs: what they do to positions and normals, whose weights they share, and that they survive
// files.
#include <gtest/gtest.h>

#include <cmath>

#include "formats/common/errors.h"
#include "formats/rig/rig_morphs.h"
#include "formats/rig/rig_poses.h"
#include "formats/source/source_readers.h"
#include "formats/stage/morphs_stored.h"
#include "tests/difference.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_morphs {
namespace {

using samples::EditableGlb;

constexpr std::size_t kTargets = 6;  // targets of the face (data-samples/README.md)

Rig readEdited(const EditableGlb& glb, const std::string& name = "edited_face.glb") {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
    samples::writeText(path, glb.bytes());
    return readRig({path});
}

std::vector<Vec3> vectorsAt(const EditableGlb& glb, int accessor) {
    std::vector<Vec3> out(glb.json["accessors"][std::size_t(accessor)]["count"].get<std::size_t>());
    std::memcpy(out.data(), glb.binary.data() + glb.offsetOf(accessor), out.size() * sizeof(Vec3));
    return out;
}

RestShape posed(const Rig& rig, int clip, double time) {
    const RigPose pose = evaluatePose(rig, clip, time);
    RestShape out;
    skinMorphed(rig.mesh, rig.skin, rig.rest_normals, {pose.bones, pose.weights}, out);
    return out;
}

// position = skin(POSITION + sum of weight * target), from the file's own numbers: no shortcut of the reader stands in
// for them. Positions are about 0.5; 3e-8 was measured.
TEST(RigMorphs, ShapeTheMeshBeforeTheSkinMovesIt) {
    const EditableGlb glb = EditableGlb::of("face");
    const Rig rig = samples::readSample("face");
    ASSERT_EQ(rig.mesh.morphs.names, (std::vector<std::string>{"jaw", "smile", "pout", "blink.L", "blink.R", "frown"}));
    const nlohmann::json& primitive = glb.json["meshes"][0]["primitives"][0];
    const std::vector<Vec3> rest = vectorsAt(glb, primitive["attributes"]["POSITION"]);
    for (const double time : {0.0, 0.35, 2.2}) {
        const RigPose pose = evaluatePose(rig, 1, time);
        ASSERT_EQ(pose.weights.size(), kTargets);
        const RestShape found = posed(rig, 1, time);
        std::vector<Vec3> shaped = rest;
        for (std::size_t t = 0; t < kTargets; ++t) {
            const std::vector<Vec3> target = vectorsAt(glb, primitive["targets"][t]["POSITION"]);
            for (std::size_t v = 0; v < shaped.size(); ++v) shaped[v] = shaped[v] + pose.weights[t] * target[v];
        }
        Largest worst;
        for (std::size_t r = 0; r < shaped.size(); ++r) {
            const std::uint32_t v = rig.mesh.source_vertex[r];
            Vec3d expected;
            for (std::size_t k = v * std::size_t(rig.skin.influences); k < (v + 1) * std::size_t(rig.skin.influences);
                 ++k)
                expected += double(rig.skin.weights[k]) * toDouble(pose.bones[rig.skin.joints[k]].point(shaped[r]));
            worst.add(length(expected - toDouble(found.positions[v])));
        }
        EXPECT_LT(worst, 2e-7) << time;
    }
}

// The file gives no normals for its targets. At weight 1 of one target the normals are then those of its triangles.
TEST(RigMorphs, WithoutNormalsInTheFileTheyFollowTheTriangles) {
    const Rig rig = samples::readSample("face");
    std::vector<float> weights(kTargets);
    weights[0] = 1;
    const RestShape shape = restShape(rig.mesh.morphs, {rig.mesh.rest_positions, rig.rest_normals}, weights);
    const std::vector<Vec3> expected = vertexNormals(rig.mesh.triangles, shape.positions);
    Largest worst, turned;
    for (std::size_t v = 0; v < expected.size(); ++v) {
        worst.add(double(length(normalized(shape.normals[v]) - expected[v])));
        turned.add(double(length(rig.rest_normals[v] - expected[v])));
    }
    EXPECT_LT(worst, 1.1e-3);  // rows that change less than 1e-3 are left out
    EXPECT_GT(turned, 0.5);
}

// Only vertices that a target changes have a row.
TEST(RigMorphs, TargetsAreSparse) {
    const MorphTargets& morphs = samples::readSample("face").mesh.morphs;
    for (std::size_t m = 0; m < morphs.count(); ++m) {
        EXPECT_GT(morphs.rowsOf(m).vertices.size(), 10u) << morphs.names[m];
        EXPECT_LT(morphs.rowsOf(m).vertices.size(), 1200u) << morphs.names[m];  // the mesh has 2402 vertices
    }
}

// The poles of the face are 48 vertices at one place. One that a target moves elsewhere is a point of its own.
TEST(RigMorphs, VerticesWeldOnlyWhereTargetsAgree) {
    EditableGlb glb = EditableGlb::of("face");
    const std::size_t welded = readEdited(glb).mesh.vertexCount();
    const int target = glb.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"];
    const Vec3 move{0, 0.01f, 0};
    std::memcpy(glb.binary.data() + glb.offsetOf(target) + 5 * sizeof(Vec3), &move, sizeof move);
    EXPECT_EQ(readEdited(glb).mesh.vertexCount(), welded + 1);
}

// A second node that draws the mesh has the same weights, unless a clip drives one of the two alone.
TEST(RigMorphs, NodesThatShareAMeshShareItsWeights) {
    EditableGlb glb = EditableGlb::of("face");
    const std::size_t first = glb.json["nodes"].size() - 1;  // the bust
    glb.json["nodes"].push_back(glb.json["nodes"][first]);
    glb.json["nodes"].back()["name"] = "twin";
    glb.json["scenes"][0]["nodes"].push_back(first + 1);
    EditableGlb alone = glb;
    for (nlohmann::json& clip : glb.json["animations"]) {
        nlohmann::json channel = clip["channels"][1];
        channel["target"]["node"] = first + 1;
        clip["channels"].push_back(channel);
    }
    const Rig together = readEdited(glb), apart = readEdited(alone);
    EXPECT_EQ(together.mesh.morphs.count(), kTargets);
    ASSERT_EQ(apart.mesh.morphs.count(), 2 * kTargets);
    EXPECT_EQ(apart.mesh.morphs.names[0], "bust/jaw");
    EXPECT_EQ(apart.mesh.morphs.names[kTargets], "twin/jaw");
    const std::vector<float> weights = weightsAt(apart, 0, 1.0);
    EXPECT_GT(*std::max_element(weights.begin(), weights.begin() + kTargets), 0.1f);
    EXPECT_EQ(*std::max_element(weights.begin() + kTargets, weights.end()), 0.0f);
}

TEST(RigMorphs, WeightsAtRestAreThoseOfTheNodeOrOfItsMesh) {
    EditableGlb glb = EditableGlb::of("face");
    glb.json["meshes"][0]["weights"] = {0.5, 0, 0, 0, 0, 0.25};
    EXPECT_EQ(evaluatePose(readEdited(glb), -1, 0).weights, (std::vector<float>{0.5f, 0, 0, 0, 0, 0.25f}));
    glb.json["nodes"].back()["weights"] = {0, 1, 0, 0, 0, 0};
    EXPECT_EQ(evaluatePose(readEdited(glb), -1, 0).weights, (std::vector<float>{0, 1, 0, 0, 0, 0}));
    glb.json["nodes"].back()["weights"] = {0, 1};
    EXPECT_THROW(readEdited(glb), InvalidInput);
}

TEST(RigMorphs, WeightsStepOrFollowLinesBetweenKeys) {
    EditableGlb glb = EditableGlb::of("face");
    const Rig linear = readEdited(glb);
    glb.json["animations"][0]["samplers"][1]["interpolation"] = "STEP";
    const Rig step = readEdited(glb);
    const std::vector<float> before = weightsAt(linear, 0, 0.1), after = weightsAt(linear, 0, 0.2);
    const std::vector<float> middle = weightsAt(linear, 0, 0.15), held = weightsAt(step, 0, 0.15);
    for (std::size_t i = 0; i < kTargets; ++i) {
        EXPECT_NEAR(middle[i], 0.5 * (before[i] + after[i]), 1e-6);
        EXPECT_EQ(held[i], before[i]);
    }
}

// Clips of weights alone are clips of the rig, with a skin and without.
TEST(RigMorphs, ClipsOfWeightsAlone) {
    EditableGlb glb = EditableGlb::of("face");
    const auto cacheOf = [&](const EditableGlb& file) {
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "weights_alone.vrm";
        samples::writeText(path, file.bytes());
        return isPointCache(path);
    };
    for (nlohmann::json& clip : glb.json["animations"]) clip["channels"].erase(0);
    const Rig rig = readEdited(glb, "weights_alone.vrm");
    ASSERT_EQ(rig.clips.size(), 4u);
    EXPECT_EQ(sampleFrames(rig, {"song"}, 0).frameCount(), 41u);
    EXPECT_GT(largestDistance(posed(rig, 2, 0).positions, posed(rig, 2, 0.5).positions), 0.005);
    EXPECT_FALSE(cacheOf(glb));
    glb.json["nodes"].back().erase("skin");
    EXPECT_FALSE(cacheOf(glb));
    const Rig head = readEdited(glb, "weights_alone.vrm");
    EXPECT_EQ(head.mesh.morphs.count(), kTargets);
    EXPECT_EQ(weightsAt(head, 0, 1.0), weightsAt(rig, 0, 1.0));
    EditableGlb moving = EditableGlb::of("face");
    moving.json["nodes"].back().erase("skin");
    EXPECT_FALSE(cacheOf(moving));
    EXPECT_EQ(readEdited(moving).mesh.morphs.count(), kTargets);
}

// A file that brings clips alone brings the weights of the node of the same name.
TEST(RigMorphs, ClipsOfAnotherFileDriveTheWeights) {
    EditableGlb glb = EditableGlb::of("face");
    glb.json["animations"].erase(0);
    const std::filesystem::path face = std::filesystem::path(testing::TempDir()) / "other_face.glb";
    samples::writeText(face, glb.bytes());
    const Rig rig = readRig({face, samples::samplePath("face")});
    ASSERT_EQ(rig.clips.size(), 7u);
    EXPECT_EQ(weightsAt(rig, 3, 1.0), weightsAt(samples::readSample("face"), 0, 1.0));
}

// Targets of another file go by their names where both files name all, whatever their order is.
TEST(RigMorphs, ClipsOfAnotherFileGoByTheNamesOfTargets) {
    EditableGlb glb = EditableGlb::of("face");
    glb.json["meshes"][0]["extras"]["targetNames"] = {"smile", "jaw", "pout", "blink.L", "puff", "frown"};
    const std::filesystem::path other = std::filesystem::path(testing::TempDir()) / "other_order.glb";
    samples::writeText(other, glb.bytes());
    const Rig alone = samples::readSample("face"), rig = readRig({samples::samplePath("face"), other});
    const auto clip = int(alone.clips.size());
    const std::vector<float> given = weightsAt(alone, 0, 1.0), got = weightsAt(rig, clip, 1.0);
    ASSERT_EQ(got.size(), kTargets);
    for (const auto& [ours, theirs] : {std::pair(0, 1), {1, 0}, {2, 2}, {3, 3}, {5, 5}})
        EXPECT_EQ(got[std::size_t(ours)], given[std::size_t(theirs)]) << ours;
    EXPECT_EQ(got[4], alone.mesh.morphs.rest_weights[4]);
    EXPECT_TRUE(std::any_of(rig.notes.begin(), rig.notes.end(), [](const RigNote& note) {
        return note.effect.find("they move nothing: 'puff'") != std::string::npos;
    }));
}

TEST(RigMorphs, TheWriterKeepsThem) {
    const Rig rig = samples::readSample("face");
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "written_face.glb";
    writeGlb(path, rig, "");
    const Rig again = readRig({path});
    EXPECT_EQ(again.mesh.morphs.names, rig.mesh.morphs.names);
    ASSERT_EQ(again.mesh.vertexCount(), rig.mesh.vertexCount());
    for (const double time : {0.0, 1.23})
        EXPECT_LT(largestDistance(posed(again, 1, time).positions, posed(rig, 1, time).positions), 1e-6);
}

TEST(RigMorphs, StageFilesKeepThemAndRefuseDamage) {
    const MorphTargets morphs = samples::readSample("face").mesh.morphs;
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "morphs.h5";
    const auto stored = [&](const MorphTargets& written) {
        Hdf5Handle file = createHdf5(path);
        writeMorphs(file, written);
        closeHdf5(file);
        return readMorphs(openHdf5(path), 2402);
    };
    EXPECT_EQ(stored(morphs), morphs);
    EXPECT_TRUE(stored({}).empty());
    MorphTargets wrong = morphs;
    wrong.first[2] = wrong.first[3] + 1;
    EXPECT_THROW(stored(wrong), InvalidInput);
    wrong = morphs;
    wrong.vertices[1] = wrong.vertices[0];
    EXPECT_THROW(stored(wrong), InvalidInput);
    wrong = morphs;
    wrong.vertices.back() = 2402;
    EXPECT_THROW(stored(wrong), InvalidInput);
    wrong = morphs;
    wrong.names[1] = wrong.names[0];
    EXPECT_THROW(stored(wrong), InvalidInput);
    EXPECT_THROW(checkMorphInputs(openHdf5(path), morphs, {"jaw"}), InvalidInput);
}

// A back has the position of its front and the opposite normal.
TEST(RigMorphs, BacksMoveWithTheirFronts) {
    const Rig rig = samples::readSample("face");
    const Mesh sheet = withBacks(rig.mesh);
    std::vector<Vec3> normals = rig.rest_normals;
    appendBackNormals(normals);
    const std::vector<float> weights{1, 0.5f, 0, 0, 0.3f, 0};
    const RestShape shape = restShape(sheet.morphs, {sheet.rest_positions, normals}, weights);
    const std::size_t fronts = rig.mesh.vertexCount();
    for (std::size_t v = 0; v < fronts; ++v) {
        EXPECT_EQ(shape.positions[v], shape.positions[fronts + v]);
        EXPECT_EQ(shape.normals[v], -shape.normals[fronts + v]);
    }
}

}  // namespace
}  // namespace penumbra::test_rig_morphs
