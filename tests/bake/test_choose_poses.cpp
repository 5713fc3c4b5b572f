// Tests the choice of poses: their distance, and the farthest and the representative ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "bake/common/random_numbers.h"
#include "bake/poses/choose_poses.h"
#include "bake/source/frame_choice.h"
#include "formats/rig/rig_matrix.h"
#include "formats/source/source_readers.h"

namespace penumbra::test_choose_poses {
namespace {

std::filesystem::path sample(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

PoseFeatures line(const std::vector<float>& values) { return {values.size(), 1, values}; }

// The mean is 4.96, so 5 comes first; then the end farther from it, the other end, and the middles of the gaps.
TEST(ChoosePoses, FarthestPicksTheExtremesOfALine) {
    std::vector<float> values(101);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.1f * float(i);
    values[0] = -4;  // mean 4.96
    const ChosenPoses chosen = chooseFarthest(line(values), 5, 2);
    EXPECT_THAT(chosen.frames, testing::ElementsAre(50, 0, 100, 5, 75));
    EXPECT_NEAR(chosen.distance[1], 9, 1e-6);
    EXPECT_NEAR(chosen.distance[2], 5, 1e-6);
    // 0.5 lies 4.5 from both -4 and 5, which is the farthest of all that is left.
    EXPECT_NEAR(chosen.distance[3], 4.5, 1e-6);
    EXPECT_NEAR(chosen.distance[4], 2.5, 1e-6);
}

// There are three tight groups of very different size. Three frames take one from each.
TEST(ChoosePoses, FarthestVisitsSmallGroups) {
    PoseFeatures points{1000, 2, {}};
    std::uint64_t state = 9;
    for (std::size_t f = 0; f < 1000; ++f) {
        const bool left = f == 137, top = f == 991 || f == 992;
        points.values.push_back(float((left ? -5 : 5) + 0.01 * nextUniform(state)));
        points.values.push_back(float((top ? 8 : 0) + 0.01 * nextUniform(state)));
    }
    const ChosenPoses chosen = chooseFarthest(points, 3, 2);
    EXPECT_TRUE(std::count(chosen.frames.begin(), chosen.frames.end(), 137u));
    EXPECT_EQ(std::count(chosen.frames.begin(), chosen.frames.end(), 991u) +
                  std::count(chosen.frames.begin(), chosen.frames.end(), 992u),
              1);
    EXPECT_LT(chosen.largest_gap, 0.015);  // sqrt(2) 0.01
}

TEST(ChoosePoses, SameChoiceForAnyThreadCountAndPrefixesOfALongerOne) {
    PoseFeatures points{2000, 7, {}};
    std::uint64_t state = 3;
    for (std::size_t i = 0; i < 14000; ++i) points.values.push_back(float(nextUniform(state)));
    const ChosenPoses all = chooseFarthest(points, 60, 1);
    for (const int threads : {2, 8}) EXPECT_EQ(chooseFarthest(points, 60, threads).frames, all.frames);
    const ChosenPoses part = chooseFarthest(points, 20, 2);
    EXPECT_TRUE(std::equal(part.frames.begin(), part.frames.end(), all.frames.begin()));
    EXPECT_EQ(part.largest_gap, all.distance[20]);
    EXPECT_TRUE(std::is_sorted(all.distance.rbegin(), all.distance.rend() - 1));
    // Gonzalez proves a factor of 2 to the best choice, so random ones are never half as good.
    EXPECT_GT(chooseRandom(points, 60, 1, 2).largest_gap, all.largest_gap / 2);
}

// There are a group of 90 frames, one of 9 and a far single one. Medians go where the frames are, and to the single
// one last.
TEST(ChoosePoses, RepresentativeFollowsTheCrowd) {
    std::vector<float> values{20};
    for (int i = 0; i < 90; ++i) values.push_back(0.01f * float(i));
    for (int i = 0; i < 9; ++i) values.push_back(5 + 0.01f * float(i));
    const ChosenPoses chosen = chooseRepresentative(line(values), 3, 2);
    EXPECT_THAT(chosen.frames, testing::ElementsAre(testing::AllOf(testing::Ge(1u), testing::Le(90u)),
                                                    testing::AllOf(testing::Ge(91u), testing::Le(99u)), 0));
    EXPECT_NEAR(chosen.distance[2], 15, 0.1);
}

// The queue saves computing gains, and still gives the plain greedy choice.
TEST(ChoosePoses, RepresentativeIsTheGreedyChoice) {
    PoseFeatures points{120, 2, {}};
    std::uint64_t state = 11;
    for (std::size_t i = 0; i < 240; ++i) points.values.push_back(float(nextUniform(state)));
    const ChosenPoses chosen = chooseRepresentative(points, 10, 1);
    EXPECT_EQ(chooseRepresentative(points, 10, 8).frames, chosen.frames);
    const auto apart = [&](std::size_t a, std::size_t b) {
        return double(std::hypot(points.row(a)[0] - points.row(b)[0], points.row(a)[1] - points.row(b)[1]));
    };
    std::vector<double> gap(120, 1e9);
    for (const std::size_t picked : chosen.frames) {
        const auto total_with = [&](std::size_t f) {
            double total = 0;
            for (std::size_t i = 0; i < 120; ++i) total += std::min(gap[i], apart(f, i));
            return total;
        };
        for (std::size_t f = 0; f < 120; ++f) EXPECT_GE(total_with(f), total_with(picked) - 1e-4);
        for (std::size_t i = 0; i < 120; ++i) gap[i] = std::min(gap[i], apart(picked, i));
    }
    EXPECT_NEAR(chosen.mean_gap, std::accumulate(gap.begin(), gap.end(), 0.0) / 120, 1e-6);
    EXPECT_LT(chosen.mean_gap, chooseFarthest(points, 10, 1).mean_gap);
}

TEST(ChoosePoses, EqualPosesAreChosenOnce) {
    EXPECT_EQ(chooseRepresentative(line({1, 1, 1, 2, 2, 1}), 6, 1).frames.size(), 2u);
    EXPECT_EQ(chooseFarthest(line({1, 1, 1, 2, 2, 1}), 6, 1).frames.size(), 2u);
    EXPECT_EQ(chooseFarthest({4, 0, {}}, 3, 1).frames.size(), 1u);  // one bone: nothing to tell poses apart
}

TEST(ChoosePoses, RandomChoiceIsWithoutRepetitionAndFollowsTheSeed) {
    const PoseFeatures points = line(std::vector<float>(50, 1.0f));
    const ChosenPoses all = chooseRandom(points, 50, 4, 1);
    EXPECT_EQ(std::set<std::size_t>(all.frames.begin(), all.frames.end()).size(), 50u);
    EXPECT_EQ(chooseRandom(points, 50, 4, 8).frames, all.frames);
    EXPECT_NE(chooseRandom(points, 50, 5, 1).frames, all.frames);
}

// --- Pose distance --------------------------------------------------------------------------------------------------

double distance(const PoseFeatures& features, std::size_t a, std::size_t b) {
    double sum = 0;
    for (std::size_t i = 0; i < features.width; ++i) sum += std::pow(features.row(a)[i] - features.row(b)[i], 2);
    return std::sqrt(sum);
}

// Each of two bones has one neighbour of weight 1, so that d^2 = s_0 |change of p_01|^2 + s_1 |change of p_10|^2.
TEST(PoseFeatures, TwoBonesMatchTheFormula) {
    const Rig rig = readRig({sample("bend.glb")});
    ASSERT_EQ(rig.skin.jointCount(), 2u);
    const std::vector<RigFrame> frames = rigFrames(rig, sampleFrames(rig, {}, 2));
    const PoseFeatures features = poseFeatures(rig, frames, 2);
    ASSERT_EQ(features.width, 6u);
    const std::vector<Vec3> centers = jointCenters(rig.mesh, rig.skin);
    double share[2] = {0, 0};
    for (std::size_t i = 0; i < rig.skin.weights.size(); ++i)
        share[rig.skin.joints[i]] += double(rig.skin.weights[i]) / double(rig.mesh.vertexCount());
    const auto seen = [&](std::size_t f, std::size_t from) {  // rigid bones: the inverse is the transpose
        const std::vector<Affine> bones = evaluatePose(rig, frames[f].clip, frames[f].time).bones;
        const Vec3 moved = bones[1 - from].point(centers[1 - from]) - bones[from].translation();
        return transposed(bones[from].linear()) * moved / float(boxDiagonal(rig.mesh.rest_positions));
    };
    for (std::size_t f = 1; f < frames.size(); ++f) {
        double expected = 0;
        for (std::size_t from : {0u, 1u}) {
            const Vec3 change = seen(f, from) - seen(0, from);
            expected += share[from] * double(dot(change, change));
        }
        EXPECT_NEAR(distance(features, 0, f), std::sqrt(expected), 2e-6) << f;  // 3e-7 measured
    }
}

// A node above all others turns and moves the character. No distance changes.
TEST(PoseFeatures, RootMotionDoesNotCount) {
    Rig rig = readRig({sample("capsule_man.glb")});
    const std::vector<RigFrame> frames = rigFrames(rig, sampleFrames(rig, {}, 2));
    const PoseFeatures before = poseFeatures(rig, frames, 2);
    Node top;
    top.translation = {3, -1, 7};
    top.rotation = rotationOf({0.3, 1.9, -0.4});
    rig.nodes.insert(rig.nodes.begin(), top);
    for (std::size_t n = 1; n < rig.nodes.size(); ++n) ++rig.nodes[n].parent;  // -1 becomes 0
    for (int& node : rig.node_of_joint) ++node;
    for (Clip& clip : rig.clips)
        for (Channel& channel : clip.channels) ++channel.node;
    const PoseFeatures after = poseFeatures(rig, frames, 2);
    // 5e-7 was measured: bones are floats, 8 m from the origin. (The order of columns may differ where two are
    // equally near.)
    for (std::size_t f = 1; f < frames.size(); ++f)
        EXPECT_NEAR(distance(before, 0, f), distance(after, 0, f), 5e-6) << f;
    EXPECT_GT(distance(before, 0, 5), 0.01);
}

TEST(PoseFeatures, SameForAnyThreadCount) {
    const Rig rig = readRig({sample("capsule_man.glb")});
    const std::vector<RigFrame> frames = rigFrames(rig, sampleFrames(rig, {}, 5));
    const std::vector<float> one = poseFeatures(rig, frames, 1).values;
    for (const int threads : {2, 8}) EXPECT_EQ(poseFeatures(rig, frames, threads).values, one);
}

}  // namespace
}  // namespace penumbra::test_choose_poses
