#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/common/errors.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/model_file.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"
#include "tests/synthetic_cloth.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_model_file {
namespace {

void expectSame(const ClusterModel& a, const ClusterModel& b) {
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.joint, b.joint);
    EXPECT_EQ(a.groups, b.groups);
    EXPECT_EQ(a.group_weight, b.group_weight);
    EXPECT_EQ(a.group_min, b.group_min);
    EXPECT_EQ(a.group_max, b.group_max);
    EXPECT_EQ(a.unit_group, b.unit_group);
    EXPECT_EQ(a.center, b.center);
    EXPECT_EQ(a.feature_mean, b.feature_mean);
    EXPECT_EQ(a.input_basis, b.input_basis);
    EXPECT_EQ(a.input_min, b.input_min);
    EXPECT_EQ(a.input_max, b.input_max);
    EXPECT_EQ(a.hidden, b.hidden);
    EXPECT_EQ(a.weights, b.weights);
    EXPECT_EQ(a.bias, b.bias);
    EXPECT_EQ(a.mean, b.mean);
    EXPECT_EQ(a.basis, b.basis);
    EXPECT_EQ(a.ridge, b.ridge);
    EXPECT_EQ(a.train_error, b.train_error);
    EXPECT_EQ(std::isnan(a.holdout_error), std::isnan(b.holdout_error));
    if (!std::isnan(a.holdout_error)) {
        EXPECT_EQ(a.holdout_error, b.holdout_error);
    }
}

TEST(ModelFile, RoundTrip) {
    for (FeatureKind features : {FeatureKind::kJointAngles, FeatureKind::kRelativeBones}) {
        const Model written = samples::model(features);
        const Model read = samples::roundTrip(written, writeModel, readModel);
        EXPECT_EQ(read.mesh.triangles, written.mesh.triangles);
        EXPECT_EQ(read.mesh.rest_positions, written.mesh.rest_positions);
        EXPECT_EQ(read.rest_normals, written.rest_normals);
        EXPECT_EQ(read.rest_tangents, written.rest_tangents);
        EXPECT_EQ(read.skin.weights, written.skin.weights);
        EXPECT_EQ(read.skin.rest_transforms, written.skin.rest_transforms);
        EXPECT_EQ(read.skin.inverse_bind, written.skin.inverse_bind);
        EXPECT_EQ(read.frames.time, written.frames.time);
        EXPECT_EQ(read.bones, written.bones);
        EXPECT_EQ(read.pose_size, written.pose_size);
        EXPECT_EQ(read.pose, written.pose);
        EXPECT_EQ(read.holdout_clips, written.holdout_clips);
        EXPECT_EQ(read.convention, written.convention);
        EXPECT_EQ(read.features, features);
        EXPECT_EQ(read.feature_scale, written.feature_scale);
        EXPECT_EQ(read.joint_centers, written.joint_centers);
        EXPECT_EQ(read.input_variance, written.input_variance);
        EXPECT_EQ(read.output_variance, written.output_variance);
        EXPECT_EQ(read.cluster_of_vertex, written.cluster_of_vertex);
        ASSERT_EQ(read.clusters.size(), written.clusters.size());
        for (std::size_t c = 0; c < read.clusters.size(); ++c) expectSame(read.clusters[c], written.clusters[c]);
        ASSERT_EQ(read.clip_errors.size(), 2u);
        EXPECT_EQ(read.clip_errors[1].clip, "run");
        EXPECT_TRUE(read.clip_errors[1].held_out);
        EXPECT_EQ(read.clip_errors[1].relative_error, 0.6);
        EXPECT_EQ(read.clip_errors[1].rms_v, 0.03);
        EXPECT_EQ(read.clip_errors[1].ambient_error, 0.04);
        EXPECT_EQ(toJson(read.provenance), toJson(written.provenance));
    }
}

// Makes a model of another kind from the sample's 3 inputs and 2 components.
Model modelOf(ModelKind kind) {
    Model model = samples::model(FeatureKind::kRelativeBones);
    model.kind = kind;
    ClusterModel& cluster = model.clusters[0];
    if (kind == ModelKind::kQuadratic) cluster.weights = samples::numbers(2 * 9, 5);
    if (kind == ModelKind::kNeural) {
        cluster.hidden = samples::numbers(5 * 4, 4);
        cluster.weights = samples::numbers(2 * 5, 5);
    }
    return model;
}

TEST(ModelFile, RoundTripOfQuadraticAndNeural) {
    for (ModelKind kind : {ModelKind::kQuadratic, ModelKind::kNeural}) {
        const Model written = modelOf(kind);
        const Model read = samples::roundTrip(written, writeModel, readModel);
        EXPECT_EQ(read.kind, kind);
        for (std::size_t c = 0; c < 2; ++c) expectSame(read.clusters[c], written.clusters[c]);
    }
}

Model nearTube() {
    Model model = synthetic::composedTube();
    synthetic::addNearParts(model, 3);  // the parts beside a part are 2 at most
    return model;
}

TEST(ModelFile, RoundTripOfModelsInParts) {
    for (const Model& written : {synthetic::tubeModel({.kind = ModelKind::kAdditive}), synthetic::composedTube(),
                                 synthetic::composedTube({}, {.local_steps = 2, .residual = false}),
                                 synthetic::litTube(), synthetic::clothModel(), nearTube()}) {
        const Model read = samples::roundTrip(written, writeModel, readModel);
        EXPECT_EQ(read.kind, written.kind);
        ASSERT_EQ(read.clusters.size(), written.clusters.size());
        for (std::size_t c = 0; c < read.clusters.size(); ++c) expectSame(read.clusters[c], written.clusters[c]);
        EXPECT_EQ(read.indirect.has_value(), written.indirect.has_value());
        ASSERT_EQ(read.composition.has_value(), written.composition.has_value());
        if (!read.composition) continue;
        EXPECT_EQ(read.composition->local_steps, written.composition->local_steps);
        EXPECT_EQ(read.composition->steps, written.composition->steps);
        EXPECT_EQ(read.composition->fields.values, written.composition->fields.values);
        EXPECT_EQ(read.composition->near_count, written.composition->near_count);
        EXPECT_EQ(read.composition->near_parts, written.composition->near_parts);
        EXPECT_EQ(read.composition->near_gains, written.composition->near_gains);
        ASSERT_EQ(read.composition->residual.size(), written.composition->residual.size());
        for (std::size_t c = 0; c < read.composition->residual.size(); ++c)
            expectSame(read.composition->residual[c], written.composition->residual[c]);
    }
}

// Returns what the reader says of the model that `change` leaves.
std::string refusalOfNear(const std::function<void(Composition&)>& change) {
    Model model = nearTube();
    change(*model.composition);
    const samples::Folder folder("near_parts");
    const std::filesystem::path path = folder.path / "x.model.h5";
    writeModel(path, model);
    try {
        (void)readModel(path);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "accepted";
}

TEST(ModelFile, RefusesNearPartsThatCannotBe) {
    const auto refusal = [](std::size_t entry, std::uint16_t part) {
        return refusalOfNear([&](Composition& c) { c.near_parts[entry] = part; });
    };
    // Part 2 of 5 has the near parts 1, 3 and none.
    EXPECT_EQ(refusal(8, kNoPart), "accepted");
    EXPECT_THAT(refusal(8, 5), testing::HasSubstr("/composition/near_parts: entry 8, part 5, is not below 5"));
    EXPECT_THAT(refusal(8, 2), testing::HasSubstr("is near itself"));
    EXPECT_THAT(refusal(8, 4), testing::HasSubstr("is a far part of part 2"));
    EXPECT_THAT(refusal(8, 1), testing::HasSubstr("occurs twice for part 2"));
    EXPECT_THAT(refusalOfNear([](Composition& c) {
                    c.near_count = 5;
                    c.near_parts.assign(25, kNoPart);
                    c.near_gains.assign(c.part_of_vertex.size() * 5, 128);
                }),
                testing::HasSubstr("/composition/near_parts: has 5 columns, not 1..4"));
}

// A prop with a root of its own has no bones nearby, so its cluster has nothing to look at.
TEST(ModelFile, RoundTripOfAClusterWithoutGroups) {
    Model written = samples::model(FeatureKind::kRelativeBones);
    for (std::vector<float>* of_group :
         {&written.clusters[1].group_weight, &written.clusters[1].group_min, &written.clusters[1].group_max})
        of_group->clear();
    written.clusters[1].groups.clear();
    const Model read = samples::roundTrip(written, writeModel, readModel);
    EXPECT_TRUE(read.clusters[1].groups.empty());
    EXPECT_TRUE(read.clusters[1].group_min.empty());
    for (std::size_t c = 0; c < 2; ++c) expectSame(read.clusters[c], written.clusters[c]);
}

TEST(ModelFile, RoundTripOfADeformingMesh) {
    for (FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const Model written = samples::deformingModel(features);
        const Model read = samples::roundTrip(written, writeModel, readModel);
        EXPECT_TRUE(read.mesh.two_sided);
        EXPECT_TRUE(read.deforming);
        EXPECT_EQ(read.features, features);
        EXPECT_EQ(read.mesh.triangles, written.mesh.triangles);
        EXPECT_EQ(read.positions, written.positions);
        EXPECT_EQ(read.input_names, written.input_names);
        EXPECT_EQ(read.input_joints, written.input_joints);
        EXPECT_EQ(read.pose_mean, written.pose_mean);
        EXPECT_EQ(read.pose_basis, written.pose_basis);
        EXPECT_EQ(read.pose, written.pose);
        for (std::size_t c = 0; c < 2; ++c) expectSame(read.clusters[c], written.clusters[c]);
    }
}

// A reader of the arrays would trip over this later; it must be refused at once, with the field's name.
void expectRefused(const Model& model, const std::string& field) {
    const samples::Folder folder("model_refused");
    writeModel(folder.path / "x.model.h5", model);
    try {
        readModel(folder.path / "x.model.h5");
        ADD_FAILURE() << "accepted, though " << field << " is wrong";
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("x.model.h5"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
}

TEST(ModelFile, RefusesDeformingMeshesThatDoNotFitTogether) {
    const Model good = samples::deformingModel(FeatureKind::kDihedrals);
    const std::size_t fronts = good.mesh.frontVertexCount();
    const auto refused = [&](const std::string& field, const std::function<void(Model&)>& spoil) {
        Model bad = good;
        spoil(bad);
        expectRefused(bad, field);
    };
    refused("/mesh/rest_positions", [&](Model& m) { m.mesh.rest_positions[fronts].x += 1; });
    refused("/mesh/triangles", [](Model& m) { m.mesh.triangles.back() = m.mesh.triangles.front(); });
    refused("/mesh/triangles", [&](Model& m) { m.mesh.triangles[0][0] = std::uint32_t(fronts); });
    refused("/mesh/source_vertex", [&](Model& m) { m.mesh.source_vertex[0] = std::uint32_t(fronts); });
    refused("two_sided", [](Model& m) { m.mesh.triangles.pop_back(); });
    refused("/skin/joints", [](Model& m) { m.skin.joints[0] = m.skin.joints[m.skin.joints.size() / 2] = 2; });
    refused("/skin/joints", [](Model& m) { m.skin.joints[0] = 1; });
    refused("/inputs/names", [](Model& m) { m.input_names[1] = "wind"; });
    refused("/inputs/joints", [](Model& m) { m.input_joints[0].columns = 2; });
    refused("/inputs/joints", [](Model& m) { m.input_joints[1].column = 4; });
    refused("/inputs/joints", [](Model& m) { m.input_joints[1].joint = 2; });
    refused("/inputs/joints", [](Model& m) { m.input_joints[1].joint = 4; });
    refused("/inputs/joints", [](Model& m) { m.input_joints.erase(m.input_joints.begin() + 1); });
    refused("joint", [](Model& m) { m.clusters[0].joint = int(m.skin.jointCount()) - 1; });
    refused("features", [](Model& m) { m.features = FeatureKind::kJointAngles; });
    refused("features", [](Model& m) { m.deforming = false; });
}

TEST(ModelFile, RefusesWhatDoesNotFitTogether) {
    const Model good = samples::model(FeatureKind::kRelativeBones);
    Model bad = good;
    bad.clusters[0].vertices[0] = 99;
    expectRefused(bad, "/clusters/0000/vertices");
    bad = good;
    bad.clusters[1].vertices[0] = 0;
    expectRefused(bad, "/clusters/0001/vertices");
    bad = good;
    bad.clusters[0].joint = 2;
    expectRefused(bad, "attribute joint");
    bad = good;
    bad.clusters[0].feature_mean.resize(24);
    bad.clusters[0].input_basis.resize(3 * 24);
    expectRefused(bad, "/clusters/0000/feature_mean");
    bad = good;
    bad.mesh.triangles[0][0] = 12;
    expectRefused(bad, "/mesh/triangles");
    bad = good;
    bad.skin.parents = {1, 0};
    expectRefused(bad, "/skin/parents");
    bad = good;
    bad.skin.weights[0] += 0.5f;
    expectRefused(bad, "/skin/weights");
    bad = good;
    bad.skin.joint_names = {"a", "a"};
    expectRefused(bad, "/skin/joint_names");
    bad = good;
    bad.frames.clip = {1, 0, 1, 1};
    expectRefused(bad, "/frames/clip");
    bad = good;
    bad.feature_scale = 0;
    expectRefused(bad, "feature_scale");
}

TEST(ModelFile, RefusesUnitsThatDoNotFitTogether) {
    Model bad = modelOf(ModelKind::kNeural);
    bad.clusters[0].hidden = samples::numbers(5 * 3, 4);  // no bias
    expectRefused(bad, "/clusters/0000/hidden");
    bad = modelOf(ModelKind::kNeural);
    bad.kind = ModelKind::kQuadratic;
    expectRefused(bad, "/clusters/0000/hidden");
    bad = modelOf(ModelKind::kQuadratic);
    bad.kind = ModelKind::kLinear;
    expectRefused(bad, "/clusters/0000/weights");
    bad = modelOf(ModelKind::kNeural);
    bad.clusters[0].unit_group = {0};
    expectRefused(bad, "/clusters/0000/unit_group");
}

// Writes `value` over number `index` of a float dataset, as a broken tool might.
void overwrite(const std::filesystem::path& path, const char* dataset, hsize_t index, float value) {
    const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "test");
    const Hdf5Handle numbers(H5Dopen2(file, dataset, H5P_DEFAULT), H5Dclose, "test");
    const Hdf5Handle space(H5Dget_space(numbers), H5Sclose, "test");
    std::vector<float> values(std::size_t(H5Sget_simple_extent_npoints(space)));
    checkHdf5(H5Dread(numbers, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "test");
    values.at(index) = value;
    checkHdf5(H5Dwrite(numbers, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "test");
}

TEST(ModelFile, RefusesNumbersThatAreNotFinite) {
    const samples::Folder folder("model_nan");
    const std::filesystem::path path = folder.path / "x.model.h5";
    for (const char* dataset : {"/clusters/0000/weights", "/frames/bones", "/errors/rms_v", "/mesh/rest_tangents"})
        for (float value : {std::nanf(""), -INFINITY}) {
            writeModel(path, samples::model(FeatureKind::kJointAngles));
            overwrite(path, dataset, 1, value);
            try {
                readModel(path);
                ADD_FAILURE() << dataset;
            } catch (const InvalidInput& error) {
                EXPECT_NE(std::string(error.what()).find(dataset), std::string::npos) << error.what();
            }
        }
}

TEST(ModelFile, NeverWritesWhatItWouldRefuse) {
    const samples::Folder folder("model_never");
    Model bad = samples::model(FeatureKind::kJointAngles);
    bad.clusters[0].bias[1] = std::nanf("");
    EXPECT_THROW(writeModel(folder.path / "x.model.h5", bad), std::runtime_error);
    EXPECT_EQ(folder.entries(), 0u);
}

}  // namespace
}  // namespace penumbra::test_model_file
