#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/common/errors.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_transfer_file {
namespace {

using samples::transferModel;

TEST(TransferFile, RoundTripKeepsEverything) {
    for (const TransferModelKind kind : kTransferModelKinds) {
        const TransferModel model = transferModel(kind);
        const TransferModel read = samples::roundTrip(model, writeTransfer, readTransfer);
        EXPECT_EQ(read.order, model.order);
        EXPECT_EQ(read.kind, kind);
        EXPECT_EQ(read.mesh.triangles, model.mesh.triangles);
        EXPECT_EQ(read.rest_normals, model.rest_normals);
        EXPECT_EQ(read.skin.joint_names, model.skin.joint_names);
        EXPECT_EQ(read.skin.joints, model.skin.joints);
        EXPECT_EQ(read.skin.weights, model.skin.weights);
        EXPECT_EQ(read.frames.clip_names, model.frames.clip_names);
        EXPECT_EQ(read.frames.time, model.frames.time);
        EXPECT_EQ(read.bones, model.bones);
        EXPECT_EQ(read.pose, model.pose);
        EXPECT_EQ(read.pose_size, model.pose_size);
        EXPECT_EQ(read.angles, model.angles);
        EXPECT_EQ(read.pose_basis, model.pose_basis);
        EXPECT_EQ(read.weights, model.weights);
        EXPECT_EQ(read.basis, model.basis);
        EXPECT_EQ(read.mean, model.mean);
        EXPECT_EQ(read.alpha, model.alpha);
        EXPECT_EQ(read.holdout_clips, model.holdout_clips);
    }
}

// Each change makes a file that HDF5 takes and that is no model. The message names the field.
TEST(TransferFile, RefusesWhatIsNoModel) {
    const samples::Folder folder("transfer_bad");
    const auto message = [&](const std::function<void(TransferModel&)>& change) -> std::string {
        TransferModel model = transferModel(TransferModelKind::kPca);
        change(model);
        writeTransfer(folder.path / "m", model);
        try {
            (void)readTransfer(folder.path / "m");
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    using testing::HasSubstr;
    EXPECT_EQ(message([](TransferModel&) {}), "");
    EXPECT_THAT(message([](TransferModel& m) { m.angles = {0, 5, 2}; }), HasSubstr("/transfer/angles: not ascending"));
    EXPECT_THAT(message([](TransferModel& m) { m.angles = {0, 2, 6}; }), HasSubstr("/transfer/angles"));
    EXPECT_THAT(message([](TransferModel& m) { m.alpha = -1; }), HasSubstr("attribute alpha"));
    EXPECT_THAT(message([](TransferModel& m) { m.pose_size = 0, m.pose.clear(); }), HasSubstr("pose_size"));
}

}  // namespace
}  // namespace penumbra::test_transfer_file
