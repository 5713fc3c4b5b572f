// Tests the choice among kinds of made poses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bake/pilot/pose_kinds.h"

namespace penumbra::test_pose_kinds {
namespace {

using Trials = std::vector<PoseTrial>;

TEST(PoseKinds, AreClipsAloneThenMoreAndMore) {
    const PoseCounts most{200, 300, 250};
    const std::vector<PoseCounts> all = {{}, {200, 0, 0}, {0, 300, 0}, {0, 300, 250}, most};
    EXPECT_EQ(candidateKinds(most), all);
    const std::vector<PoseCounts> sampled = {{}, {200, 0, 0}};
    EXPECT_EQ(candidateKinds({200, 0, 0}), sampled) << "a kind of which there are none is tried once at most";
}

TEST(PoseKinds, ShareKeepsEveryKind) {
    EXPECT_EQ(shareOf({200, 300, 1}, 0.5), (PoseCounts{100, 150, 1}));
    EXPECT_EQ(shareOf({0, 3, 0}, 0.125), (PoseCounts{0, 1, 0}));
}

TEST(PoseKinds, OptionsListTheClipsInAnyCase) {
    EXPECT_EQ(optionsOf({}), "--choose all");
    EXPECT_EQ(optionsOf({5, 0, 0}), "--choose all --sample 5");
    EXPECT_EQ(optionsOf({5, 0, 2}), "--sample 5 --cover 2");
}

// Two folds with ratios 1/2 and 1/8: the mean is 1/4, and the logarithms differ by ln 4. Their standard error is half
// of that.
TEST(TrialRatio, IsTheGeometricMeanWithTheStandardErrorOfTheLogarithms) {
    const TrialRatio ratio = ratioOf({{1, 0, 0}, {0.5, 0.25}}, {{}, {1, 2}});
    EXPECT_NEAR(ratio.mean, 0.25, 1e-12);
    EXPECT_NEAR(ratio.noise, std::log(4) / 2, 1e-12);
    EXPECT_EQ(ratioOf({{}, {0.5}}, {{}, {1}}).noise, 0);
}

TEST(ChooseTrial, TakesTheLeastError) {
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.9, 0.9}}, {{0, 9, 0}, {0.8, 0.8}}}), 2u);
}

TEST(ChooseTrial, KeepsTheClipsAloneWhereTheGainIsSmallOrNoise) {
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}}), 0u);
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {1.1, 1.1}}}), 0u);
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.995, 0.995}}}), 0u) << "half a percent";
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.6, 1.2}}}), 0u) << "half of the folds lose";
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.6, 0.9}}}), 1u);
}

TEST(ChooseTrial, TakesFewerPosesThatAreAsGood) {
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.8, 0.8}}, {{4, 0, 0}, {0.803, 0.803}}}), 2u);
    EXPECT_EQ(chooseTrial(Trials{{{}, {1, 1}}, {{9, 0, 0}, {0.8, 0.8}}, {{4, 0, 0}, {0.81, 0.81}}}), 1u);
}

}  // namespace
}  // namespace penumbra::test_pose_kinds
