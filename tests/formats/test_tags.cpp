// Tags are found, read and placed in pictures that the test draws.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

#include "formats/camera/tag_family.h"
#include "formats/common/errors.h"
#include "tests/formats/drawn_tags.h"

namespace penumbra::test_tags {
namespace {

using samples::DrawnTag;
using samples::Photograph;
using ::testing::HasSubstr;

constexpr TagFamily kFamilies[] = {TagFamily::k36h11, TagFamily::k25h9, TagFamily::k16h5, TagFamily::k4x4_50};

double degreesBetween(const Mat3d& a, const Mat3d& b) {
    const Mat3d turn = a * transposed(b);
    return 180 / std::numbers::pi * std::acos(std::clamp((turn(0, 0) + turn(1, 1) + turn(2, 2) - 1) / 2, -1.0, 1.0));
}

Photograph fromTheSide() {
    Photograph taken;
    taken.pose = samples::lookingAt({1.2, -2.4, 1.5}, {0.1, 0.2, 0});
    return taken;
}

TEST(TagDetector, ReadsEveryFamilyAndKnowsWhichWayIsUp) {
    for (const TagFamily family : kFamilies) {
        const DrawnTag tag{family, 7, 0.8, {}};
        const Photograph taken = fromTheSide();
        TagDetector detector(kFamilies);
        const std::vector<DetectedTag> found = detector.detect(samples::photographOf(taken, {&tag, 1}), taken.response);
        ASSERT_EQ(found.size(), 1u) << nameOf(family);
        EXPECT_EQ(found[0].family, family);
        EXPECT_EQ(found[0].id, 7);
        EXPECT_EQ(found[0].flipped_bits, 0);
        for (const SeenPoint& corner : seenCorners(found[0], tag.side)) {
            const auto at = project(taken.camera, taken.pose.rotation * corner.point + taken.pose.translation);
            EXPECT_LT(std::hypot(at->x - corner.pixel.x, at->y - corner.pixel.y), 0.15) << nameOf(family);
        }
        EXPECT_NEAR(found[0].paper_code, codeOf(taken.response, 0, 0.6f), 3);
    }
}

TEST(TagDetector, PlacesTheCamera) {
    Photograph taken = fromTheSide();
    taken.camera.k1 = -0.2;
    taken.camera.k2 = 0.05;
    taken.noise = 0.004;
    const DrawnTag tag{TagFamily::k36h11, 3, 0.7, {}};
    TagDetector detector(std::span<const TagFamily>(kFamilies, 1));
    const std::vector<DetectedTag> found = detector.detect(samples::photographOf(taken, {&tag, 1}), taken.response);
    ASSERT_EQ(found.size(), 1u);
    const auto pose = estimatePose(taken.camera, seenCorners(found[0], tag.side));
    ASSERT_TRUE(pose);
    const double distance = length(taken.pose.place());
    EXPECT_LT(length(pose->pose.place() - taken.pose.place()), 0.0035 * distance);
    EXPECT_LT(degreesBetween(pose->pose.rotation, taken.pose.rotation), 0.2);
    EXPECT_LT(pose->residual, 0.3);
    EXPECT_GT(pose->margin, 0.5);
}

TEST(TagDetector, SeesInTheDarkAndTellsClippedPaper) {
    const DrawnTag tag{TagFamily::k4x4_50, 11, 0.8, {}};
    TagDetector detector(kFamilies);
    Photograph dark = fromTheSide(), bright = fromTheSide();
    dark.paper = 0.02, dark.floor = 0.01;
    bright.paper = 1.0;
    EXPECT_EQ(detector.detect(samples::photographOf(dark, {&tag, 1}), dark.response).size(), 1u);
    const auto found = detector.detect(samples::photographOf(bright, {&tag, 1}), bright.response);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_GE(found[0].paper_code, 250);
}

TEST(TagDetector, FindsSeveralAndNothingWhereNothingIs) {
    const DrawnTag tags[] = {{TagFamily::k36h11, 5, 0.5, {0.5, 0, 0}}, {TagFamily::k36h11, 2, 0.5, {-0.5, 0.3, 0}}};
    const Photograph taken = fromTheSide();
    TagDetector detector(kFamilies);
    const auto found = detector.detect(samples::photographOf(taken, tags), taken.response);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].id, 2);
    EXPECT_EQ(found[1].id, 5);
    EXPECT_TRUE(detector.detect(samples::photographOf(taken, {}), taken.response).empty());
}

TEST(TagFamily, CodesOfArucoDifferInFourBitsHoweverTheyAreTurned) {
    const auto turned = [](unsigned code) {  // row r, column c comes from row 3 - c, column r
        unsigned out = 0;
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c) out |= ((code >> (15 - (4 * (3 - c) + r))) & 1) << (15 - (4 * r + c));
        return out;
    };
    int least = 16;
    for (std::size_t a = 0; a < kAruco4x4.size(); ++a)
        for (std::size_t b = 0; b < kAruco4x4.size(); ++b) {
            unsigned code = kAruco4x4[b];
            for (int quarter = 0; quarter < 4; ++quarter, code = turned(code))
                if (a != b || quarter > 0) least = std::min(least, std::popcount(unsigned(kAruco4x4[a]) ^ code));
        }
    EXPECT_EQ(least, 4);  // the distance that OpenCV's dictionary promises
}

TEST(TagPose, IsExactForExactCorners) {
    const PinholeCamera camera{600, 322, 236, 640, 480, -0.2, 0.05};
    for (const Vec3d eye : {Vec3d{0.5, -2, 1}, Vec3d{0.01, 0.02, 3}, Vec3d{-2, 0.4, 0.6}}) {
        const CameraPose pose = samples::lookingAt(eye, {0.1, 0, 0});
        std::vector<SeenPoint> seen;
        for (const Vec3d corner : tagCorners(0.4))
            seen.push_back({corner, *project(camera, pose.rotation * corner + pose.translation)});
        const auto found = estimatePose(camera, seen);
        ASSERT_TRUE(found);
        EXPECT_LT(length(found->pose.place() - eye), 1e-6);
        EXPECT_LT(found->residual, 1e-6);
        EXPECT_EQ(findProblem(found->pose), "");
    }
}

TEST(TagPose, TheMarginTellsWhereTwoPosesFit) {
    const PinholeCamera camera{640, 319.5, 239.5, 640, 480, 0, 0};
    const auto marginFrom = [&](double distance) {  // for a tag that is seen obliquely, with corners off by .3 pixels
        const CameraPose pose = samples::lookingAt({0, -distance * 0.5, distance * 0.87}, {0, 0, 0});
        std::vector<SeenPoint> seen;
        const double off[] = {0.3, -0.2, 0.25, -0.3};
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec3d corner = tagCorners(0.4)[i];
            seen.push_back({corner, *project(camera, pose.rotation * corner + pose.translation)});
            seen.back().pixel.x += off[i];
            seen.back().pixel.y -= off[3 - i];
        }
        return estimatePose(camera, seen)->margin;
    };
    EXPECT_GT(marginFrom(1), 0.8);
    EXPECT_LT(marginFrom(12), 0.4);
}

TEST(TagChoice, IsReadOrNamed) {
    const TagChoice tag = parseTag("36h11:3:0.7");
    EXPECT_EQ(tag.family, TagFamily::k36h11);
    EXPECT_EQ(tag.id, 3);
    EXPECT_EQ(tag.side, 0.7);
    for (const char* text : {"", "36h11", "36h11:3", "36h12:3:0.7", "36h11:x:0.7", "36h11:3:0", "36h11:-1:1",
                             "36h11:587:1", "4x4_50:50:1", "36h11:3:nan", "36h11:3:1m", "36h11:3:1:2"})
        EXPECT_THROW((void)parseTag(text), BadOption) << text;
}

}  // namespace
}  // namespace penumbra::test_tags
