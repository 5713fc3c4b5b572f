// The pose of a bracket by a tag: from its corners, and from its edges.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "formats/capture/bracket_pose.h"
#include "formats/capture/tag_edges.h"
#include "tests/difference.h"
#include "tests/formats/drawn_tags.h"

namespace penumbra::test_bracket_pose {
namespace {

const TagChoice kTag{TagFamily::k36h11, 3, 0.7};
const std::vector<double> kExposures = {4, 1, 0.25};
const CameraResponse kSrgb = *knownResponse("srgb");

samples::Photograph camera(double exposure) {
    samples::Photograph taken;
    taken.camera.k1 = -0.1;
    taken.pose = samples::lookingAt({-0.64, -2, 1}, {-0.4, 0, 0});
    taken.paper *= exposure;
    taken.floor *= exposure;
    taken.noise = 0.004;
    return taken;
}

std::vector<TexturePicture> bracket(std::span<const samples::DrawnTag> tags) {
    std::vector<TexturePicture> pictures;
    for (double exposure : kExposures) pictures.push_back(samples::photographOf(camera(exposure), tags));
    return pictures;
}

// Measured: the place within 4 mm by the detector's corners, and within .5 mm by the edges, at 2.3 m.
TEST(BracketPose, EdgesAreMoreExactThanCorners) {
    const samples::DrawnTag tag{kTag.family, kTag.id, kTag.side, {}};
    const std::vector<TexturePicture> pictures = bracket(std::span(&tag, 1));
    const samples::Photograph truth = camera(1);
    const BracketPose first = poseOfBracket(pictures, truth.camera, kSrgb, kTag, 2);
    EXPECT_FALSE(first.clipped);
    EXPECT_GE(first.pictures, 2);  // the paper of the first one is clipped
    const RadiancePicture merged = mergeExposures(pictures, kExposures, kSrgb);
    const BracketPose fine = refineByEdges(merged, truth.camera, kTag, first);
    const double corners = length(first.estimate.pose.place() - truth.pose.place());
    const double edges = length(fine.estimate.pose.place() - truth.pose.place());
    EXPECT_LT(corners, 0.02);
    EXPECT_LT(edges, 0.0015);
    EXPECT_LT(edges, corners);
}

TEST(BracketPose, NamesWhatIsWrong) {
    const std::vector<TexturePicture> none = {samples::photographOf(camera(1), {})};
    EXPECT_THAT([&] { (void)poseOfBracket(none, camera(1).camera, kSrgb, kTag, 1); },
                testing::ThrowsMessage<std::invalid_argument>("no picture shows the tag 36h11:3"));
    const samples::DrawnTag two[] = {{kTag.family, kTag.id, 0.4, {-0.6, 0, 0}},
                                     {kTag.family, kTag.id, 0.4, {0.2, 0, 0}}};
    EXPECT_THAT([&] { (void)poseOfBracket(bracket(two), camera(1).camera, kSrgb, kTag, 1); },
                testing::ThrowsMessage<std::invalid_argument>("a picture shows two tags 36h11:3"));
}

TEST(TagEdges, AreNoneWhereThereIsNoTag) {
    const RadiancePicture merged =
        mergeExposures(std::vector{samples::photographOf(camera(1), {})}, std::vector{1.0}, kSrgb);
    EXPECT_FALSE(cornersByEdges({merged, camera(1).camera, camera(1).pose}, paperOf(kTag)));
}

}  // namespace
}  // namespace penumbra::test_bracket_pose
