#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/common/errors.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_lobe_file {
namespace {

using samples::lobeModel;

TEST(LobeFile, RoundTripKeepsEverything) {
    const LobeModel model = lobeModel(), read = samples::roundTrip(model, writeLobes, readLobes);
    EXPECT_EQ(read.order, model.order);
    EXPECT_EQ(read.lobes, model.lobes);
    EXPECT_EQ(read.mesh.triangles, model.mesh.triangles);
    EXPECT_EQ(read.rest_normals, model.rest_normals);
    EXPECT_EQ(read.rest_tangents, model.rest_tangents);
    EXPECT_EQ(read.skin.joint_names, model.skin.joint_names);
    EXPECT_EQ(read.cluster_of_vertex, model.cluster_of_vertex);
    EXPECT_EQ(read.joint_of_cluster, model.joint_of_cluster);
    EXPECT_EQ(read.pose_mean, model.pose_mean);
    EXPECT_EQ(read.pose_basis, model.pose_basis);
    EXPECT_EQ(read.axes, model.axes);
    EXPECT_EQ(read.weights, model.weights);
    EXPECT_EQ(read.input_variance, model.input_variance);
    EXPECT_EQ(read.ridge, model.ridge);
    EXPECT_EQ(read.holdout_clips, model.holdout_clips);
    ASSERT_EQ(read.clip_errors.size(), 2u);
    EXPECT_EQ(read.clip_errors[1].relative_error, 0.9);
}

// Each change makes a file that HDF5 takes and that is no model. The message names the field.
TEST(LobeFile, RefusesWhatIsNoModel) {
    const samples::Folder folder("lobes_bad");
    const auto message = [&](const std::function<void(LobeModel&)>& change) -> std::string {
        LobeModel model = lobeModel();
        change(model);
        writeLobes(folder.path / "m", model);
        try {
            (void)readLobes(folder.path / "m");
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    using testing::HasSubstr;
    EXPECT_EQ(message([](LobeModel&) {}), "");
    EXPECT_THAT(message([](LobeModel& m) { m.axes[3] = {0, 0, 2}; }), HasSubstr("/lobes/axes: an axis is not"));
    EXPECT_THAT(message([](LobeModel& m) { m.axes[0] = {}; }), HasSubstr("/lobes/axes: an axis is not"));
    EXPECT_THAT(message([](LobeModel& m) { m.cluster_of_vertex[1] = 2; }), HasSubstr("/lobes/cluster_of_vertex"));
    EXPECT_THAT(message([](LobeModel& m) { m.joint_of_cluster[1] = 2; }), HasSubstr("/lobes/joint_of_cluster"));
    EXPECT_THAT(message([](LobeModel& m) { m.ridge = -1; }), HasSubstr("attribute ridge"));
    EXPECT_THAT(message([](LobeModel& m) { m.input_variance = 0; }), HasSubstr("attribute input_variance"));
    EXPECT_THAT(message([](LobeModel& m) {
                    m.order = 1;
                    m.weights.resize(m.mesh.vertexCount() * 3 * 2 * 3);
                }),
                HasSubstr("attribute sh_order"));
    EXPECT_THAT(message([](LobeModel& m) {
                    m.lobes = 4;
                    m.axes.resize(m.mesh.vertexCount() * 4, {0, 0, 1});
                    m.weights.resize(m.mesh.vertexCount() * 3 * 4 * 5);
                }),
                HasSubstr("4 lobes, not 1..3"));
    EXPECT_THAT(message([](LobeModel& m) {
                    m.pose_basis.clear();
                    m.weights.resize(m.mesh.vertexCount() * 2 * 5);
                }),
                HasSubstr("/lobes/pose_basis: empty"));
}

// Whoever expects a model says what the file is and what to do.
TEST(LobeFile, IsRefusedAsAModel) {
    const samples::Folder folder("lobes_model");
    writeLobes(folder.path / "m", lobeModel());
    try {
        (void)readModel(folder.path / "m");
        ADD_FAILURE() << "accepted";
    } catch (const Unsupported& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("reference model of zonal lobes"));
    }
}

}  // namespace
}  // namespace penumbra::test_lobe_file
