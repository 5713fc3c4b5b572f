// Tests how a window handles photographs as they come: the sources, and who follows the camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "formats/common/errors.h"
#include "player/composite/live_light.h"
#include "player/composite/live_plates.h"
#include "player/composite/live_tracker.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/formats/drawn_tags.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_live {
namespace {

using samples::DrawnTag;
using samples::Photograph;

Image flat(int size, float light) {
    return {size, size, std::vector<Vec3>(std::size_t(size * size), Vec3{light, light, light}), {}};
}

TEST(LivePlates, AFolderBeginsAgain) {
    const samples::Folder folder("live_plates");
    for (int i = 0; i < 3; ++i)
        writePng(folder.path / ("p." + std::to_string(i) + ".png"), flat(4, 0.2f * float(i)), 1);
    LivePlates plates(folder.path, 4, 4);
    std::vector<std::uint8_t> first;
    for (std::size_t i = 0; i < 7; ++i) {
        Plate plate;
        ASSERT_EQ(plates.next(plate), LiveNext::kPicture);
        EXPECT_EQ(plates.number(), i % 3);
        EXPECT_LT(std::chrono::steady_clock::now() - plates.taken(), std::chrono::seconds(5));
        first.push_back(plate.codes.rgb.at(0));
    }
    EXPECT_EQ(first[0], first[3]);
    EXPECT_EQ(first[1], first[4]);
    EXPECT_LT(first[0], first[1]);
    EXPECT_LT(first[1], first[2]);
    Plate none;
    EXPECT_THROW((void)LivePlates("/nowhere.png", 4, 4).next(none), IoError);
}

Photograph seenFrom(Vec3d eye) {
    Photograph taken;
    taken.camera = {320, 159.5, 119.5, 320, 240, 0, 0};
    taken.pose = samples::lookingAt(eye, {0.2, 0, 0});
    return taken;
}

TEST(LiveTracker, KeepsTheLastPoseAndLearnsOtherTags) {
    const DrawnTag both[] = {{TagFamily::k16h5, 1, 0.4, {}}, {TagFamily::k16h5, 2, 0.4, {0.7, 0, 0}}};
    const Photograph first = seenFrom({0.3, -1.6, 1.2}), second = seenFrom({0.5, -1.5, 1.1});
    LiveTracker tracker(first.camera, {{TagFamily::k16h5, 1, 0.4}, {TagFamily::k16h5, 2, 0.4}}, first.response, 1);
    const auto off = [&](const Photograph& taken) {
        return length(tracker.track(photographOf(taken, both)).pose->place() - taken.pose.place());
    };
    EXPECT_FALSE(tracker.track(photographOf(first, {})).pose.has_value());
    EXPECT_FALSE(tracker.track(photographOf(first, {both + 1, 1})).seen) << "nobody knows where the second tag lies";
    EXPECT_LT(off(first), 0.01);
    const TrackedPose& other = tracker.track(photographOf(second, {both + 1, 1}));
    EXPECT_TRUE(other.seen);
    EXPECT_LT(length(other.pose->place() - second.pose.place()), 0.03);
    const TrackedPose& lost = tracker.track(photographOf(first, {}));
    EXPECT_FALSE(lost.seen);
    EXPECT_LT(length(lost.pose->place() - second.pose.place()), 0.03);
    EXPECT_GT(lost.milliseconds, 0);
}

TEST(LiveTracker, GoesOnWhereATagIsThereTwice) {
    const DrawnTag both[] = {{TagFamily::k16h5, 1, 0.4, {}}, {TagFamily::k16h5, 1, 0.4, {0.7, 0, 0}}};
    const Photograph taken = seenFrom({0.3, -1.6, 1.2});
    LiveTracker tracker(taken.camera, {{TagFamily::k16h5, 1, 0.4}}, taken.response, 1);
    EXPECT_TRUE(tracker.track(photographOf(taken, {both, 1})).seen);
    const TrackedPose& twice = tracker.track(photographOf(taken, both));
    EXPECT_TRUE(twice.twice);
    EXPECT_FALSE(twice.seen);
    EXPECT_LT(length(twice.pose->place() - taken.pose.place()), 0.01) << "the last pose stays";
    EXPECT_FALSE(tracker.track(photographOf(taken, {both, 1})).twice);
}

// The mean of the places that several pictures tell is nearer than what the worst of them tells.
TEST(LiveTracker, LearnsPlacesFromSeveralPictures) {
    const DrawnTag both[] = {{TagFamily::k16h5, 1, 0.4, {}}, {TagFamily::k16h5, 2, 0.4, {0.7, 0, 0}}};
    const std::vector<TagChoice> tags{{TagFamily::k16h5, 1, 0.4}, {TagFamily::k16h5, 2, 0.4}};
    const Photograph last = seenFrom({0.5, -1.5, 1.1});
    const auto off = [&](std::size_t first, std::size_t count) {
        LiveTracker tracker(last.camera, tags, last.response, 1);
        for (std::size_t i = first; i < first + count; ++i)
            tracker.track(photographOf(seenFrom({0.3 + 0.02 * double(i), -1.7, 1.2}), both));
        return length(tracker.track(photographOf(last, {both + 1, 1})).pose->place() - last.pose.place());
    };
    Largest worst;
    for (std::size_t i = 0; i < 5; ++i) worst.add(off(i, 1));
    EXPECT_LT(off(0, 5), worst.value());
    EXPECT_NE(off(0, 5), off(0, 1)) << "not the first picture alone";
}

// A ball in a uniform light of .3 shows .3 times its reflectance wherever one looks.
TEST(LiveLight, IsThatOfTheBall) {
    const Photograph taken = seenFrom({0.2, -1.0, 0.6});
    const TexturePicture picture{320, 240, std::vector<std::uint8_t>(3 * 320 * 240, 120)};
    const LiveBall ball{{{0.2, 0, 0.1}, 0.1, 0.5}, {0, 0, 0.3}, {}, 1};
    LiveLight light(ball, 3, taken.response, 2);
    const LightView* found = light.update(picture, taken.camera, taken.pose, 1);
    ASSERT_NE(found, nullptr);
    const double radiance = double(exposureOf(taken.response, 0, 120)) / 2 / 0.5;
    EXPECT_NEAR(found->sh[0], radiance * std::sqrt(4 * std::numbers::pi), 0.01 * radiance);
    for (std::size_t i = 3; i < found->sh.size(); ++i) EXPECT_NEAR(found->sh[i], 0, 0.02 * radiance);
    EXPECT_EQ(light.update(picture, taken.camera, taken.pose, 1), nullptr) << "too soon";
    EXPECT_EQ(found->suns.size(), 1u) << "a dark one";
    LiveLight away(ball, 3, taken.response, 2);
    const CameraPose turned = samples::lookingAt({0.2, -1.0, 0.6}, {0.2, -2, 0.6});
    EXPECT_EQ(away.update(picture, taken.camera, turned, 1), nullptr) << "the camera looks away";
}

// White on one side: the scene turns its light, and that of the ball stays where it was seen.
TEST(LiveLight, DoesNotTurnWithTheScenesOwn) {
    const Photograph taken = seenFrom({0.2, -1.0, 0.6});
    TexturePicture picture{320, 240, std::vector<std::uint8_t>(3 * 320 * 240, 60)};
    for (std::size_t y = 0; y < 240; ++y)
        for (std::size_t x = 3 * 160; x < 3 * 320; ++x) picture.rgb[y * 960 + x] = 200;
    LiveBall ball{{{0.2, 0, 0.1}, 0.1, 0.5}, {0, 0, 0.3}, {}, 1};
    LiveLight plain(ball, 2, taken.response, 1);
    const LightView* as_seen = plain.update(picture, taken.camera, taken.pose, 1);
    ASSERT_NE(as_seen, nullptr);
    ball.scene_turn.m = {0, 0, 1, 0, 1, 0, -1, 0, 0};  // x goes to -z, z to x
    LiveLight turned(ball, 2, taken.response, 1);
    const LightView* before = turned.update(picture, taken.camera, taken.pose, 1);
    ASSERT_NE(before, nullptr);
    std::array<float, 4> from, to;
    for (std::size_t i = 0; i < 4; ++i) from[i] = before->sh[3 * i];
    apply(makeShRotation(2, ball.scene_turn), from, to);
    EXPECT_GT(std::abs(before->sh[3] - as_seen->sh[3]) + std::abs(before->sh[9] - as_seen->sh[9]), 0.05);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(to[i], as_seen->sh[3 * i], 1e-4);
    EXPECT_LT(length(ball.scene_turn * before->suns[0].direction - as_seen->suns[0].direction), 1e-4);
}

}  // namespace
}  // namespace penumbra::test_live
