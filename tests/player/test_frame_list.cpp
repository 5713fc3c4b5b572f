// Tests which frames a run takes, and what their files are called.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "player/render/frame_list.h"
#include "tests/refusal.h"

namespace penumbra::test_frame_list {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Makes clips of 3, 2 and 4 frames.
AssetView threeClips() {
    AssetView asset;
    asset.animation.clips = {{"walk", 0, 3, false}, {"squat", 3, 2, true}, {"wave", 5, 4, false}};
    return asset;
}

std::vector<std::size_t> framesOf(const FrameChoice& choice) {
    std::vector<std::size_t> frames;
    for (const ListedFrame& at : chooseFrames(threeClips(), choice).frames) frames.push_back(at.frame);
    return frames;
}

TEST(FrameList, OneFrameIsTheFirstUnlessSaid) {
    EXPECT_THAT(framesOf({}), ElementsAre(0));
    EXPECT_THAT(framesOf({.clips = {"squat"}}), ElementsAre(3));
    EXPECT_THAT(framesOf({.clips = {"wav"}, .frame = 3}), ElementsAre(8));
}

TEST(FrameList, ASequenceCountsTheFramesOfTheChosenClipsInOrder) {
    EXPECT_THAT(framesOf({.sequence = true}), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
    EXPECT_THAT(framesOf({.clips = {"wave", "walk"}, .sequence = true}), ElementsAre(5, 6, 7, 8, 0, 1, 2));
    EXPECT_THAT(framesOf({.clips = {"all"}, .frames = FrameRange{2, 9, 3}, .sequence = true}), ElementsAre(2, 5, 8));
    const ChosenFrames chosen =
        chooseFrames(threeClips(), {.clips = {"wave", "squat"}, .frames = FrameRange{3, 6, 1}, .sequence = true});
    ASSERT_EQ(chosen.frames.size(), 3u);
    const ListedFrame& at = chosen.frames[1];
    EXPECT_THAT((std::vector<std::size_t>{at.clip, at.number, at.frame, at.listed}), ElementsAre(1, 0, 3, 4));
}

TEST(FrameList, AClipCalledAllIsThatClip) {
    AssetView asset = threeClips();
    asset.animation.clips[1].name = "all";
    const ChosenFrames chosen = chooseFrames(asset, {.clips = {"all"}, .sequence = true});
    EXPECT_THAT(chosen.clips, ElementsAre(1));
}

TEST(FrameList, WrongChoicesAreNamed) {
    const auto usage = [](const FrameChoice& choice) { return refusalBy<UsageError>([&] { framesOf(choice); }); };
    EXPECT_EQ(usage({.clips = {"run"}}), "clip: the asset has no \"run\"; it has walk, squat, wave");
    EXPECT_EQ(usage({.clips = {"w"}}), "clip: the asset has more than one \"w\"; it has walk, squat, wave");
    EXPECT_EQ(usage({.clips = {"walk", "wal"}, .sequence = true}), "clip: wal is given twice");
    EXPECT_EQ(usage({.clips = {"walk", "all"}, .sequence = true}), "clip: all cannot be combined with another clip");
    EXPECT_EQ(usage({.clips = {"squat"}, .frame = 2}), "frame: must be 0..1 for clip \"squat\", not 2");
    EXPECT_EQ(usage({.clips = {"walk", "squat"}, .frame = 1}), "frame: 1 is of one clip, and 2 are chosen");
    EXPECT_EQ(usage({.clips = {"squat"}, .frames = FrameRange{0, 3, 1}}),
              "frames: must end at most at 2, the number of sampled frames, not 3");
    EXPECT_THROW(chooseFrames(AssetView{}, {}), InvalidInput);
}

TEST(FrameRange, AStepBeyondTheEndDoesNotWrapAround) {
    const FrameRange range = parseFrameRange("5:9:18446744073709551613");
    EXPECT_THAT(framesOf({.frames = range, .sequence = true}), ElementsAre(5));
}

TEST(FramePattern, WritesTheNumberWithAtLeastItsDigits) {
    EXPECT_EQ(FramePattern("out.%04d.png").name(7), "out.0007.png");
    EXPECT_EQ(FramePattern("out.%04d.png").name(12345), "out.12345.png");
    EXPECT_EQ(FramePattern("a/b/%d.exr").name(0), "a/b/0.exr");
    EXPECT_EQ(FramePattern("%09d.png").name(42), "000000042.png");
    EXPECT_EQ(FramePattern("100%%_%02d%%.png").name(3), "100%_03%.png");
    EXPECT_EQ(FramePattern("folder%s/%d.png").name(1), "folder%s/1.png") << "folders are no patterns";
}

TEST(FramePattern, RefusesEverythingElse) {
    for (const char* bad :
         {"out.png",  "%%.png",      "%s.png",  "%4d.png", "%00d.png", "%0d.png", "%012d.png", "%-4d.png",
          "%d%d.png", "%04d_%d.png", "%ld.png", "%n.png",  "%.png",    "%",       "out%",      "%0",
          "%04",      "% d.png",     "%x.png",  "%*d.png", "a%d/",     ""})
        EXPECT_THAT(refusalBy<UsageError>([&] { FramePattern pattern{bad}; }), HasSubstr("out.%04d.png")) << bad;
    EXPECT_TRUE(FramePattern::looksLikeOne("x/%q.png"));
    EXPECT_FALSE(FramePattern::looksLikeOne("x%d/q.png"));
}

}  // namespace
}  // namespace penumbra::test_frame_list
