// Tests the sampling of poses within joint limits, and lists of poses through files and bakes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <set>

#include "bake/poses/pose_list.h"
#include "bake/poses/sample_poses.h"
#include "bake/source/frame_choice.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/difference.h"

namespace penumbra::test_poses {
namespace {

std::filesystem::path sample(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> values) {
    std::sort(values.begin(), values.end());
    return values;
}

// --- Sampling -------------------------------------------------------------------------------------------------------

TEST(Halton, PlainPointsAreTheRadicalInverses) {
    const HaltonDimension two(0, 0), three(1, 0), prime(24, 0);  // the 25th prime is 97
    const double halves[] = {0, 1. / 2, 1. / 4, 3. / 4, 1. / 8, 5. / 8}, thirds[] = {0, 1. / 3, 2. / 3, 1. / 9, 4. / 9};
    for (std::uint64_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(two.value(i), halves[i]);
    for (std::uint64_t i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(three.value(i), thirds[i]);
    EXPECT_DOUBLE_EQ(prime.value(1), 1. / 97);
    EXPECT_DOUBLE_EQ(prime.value(98), 1. / 97 + 1. / (97 * 97));
}

// Whatever the permutations, b^2 consecutive points have one in every interval of length 1 / b^2.
TEST(Halton, PermutedPointsFillEveryInterval) {
    for (const std::uint64_t seed : {1, 2, 77})
        for (const std::size_t dimension : {0u, 1u, 4u, 30u}) {
            const HaltonDimension halton(dimension, seed);
            const std::size_t base = std::vector<std::size_t>{2, 3, 11, 127}[dimension == 30  ? 3
                                                                             : dimension == 4 ? 2
                                                                                              : dimension];
            std::set<std::size_t> hit;
            for (std::uint64_t i = 0; i < base * base; ++i) {
                const double v = halton.value(5 * base * base + i);
                ASSERT_TRUE(v >= 0 && v < 1);
                hit.insert(std::size_t(v * double(base * base) + 1e-6));
            }
            EXPECT_EQ(hit.size(), base * base) << "seed " << seed << " dimension " << dimension;
        }
    EXPECT_NE(HaltonDimension(5, 1).value(3), HaltonDimension(5, 2).value(3));
}

// Plain Halton points of neighbouring large primes rise together (correlation 0.8 for the 60th and 61st); the
// permuted ones do not. 100 independent pairs have a correlation of 0.1 in the rms.
TEST(Halton, PermutedDimensionsAreUncorrelated) {
    Largest largest;
    for (std::size_t dimension = 0; dimension < 90; ++dimension) {
        const HaltonDimension a(dimension, 1), b(dimension + 1, 1);
        double sum = 0;
        for (std::uint64_t i = 1; i <= 100; ++i) sum += (a.value(i) - 0.5) * (b.value(i) - 0.5) / 100;
        largest.add(std::abs(12 * sum));
    }
    EXPECT_LT(largest, 0.4);  // 0.29 measured
}

// A rig whose only clip turns joint 1 about x through known angles.
Rig rigWithAngles(const std::vector<float>& angles) {
    Rig rig = readRig({sample("bend.glb")});
    std::vector<float> rotations(angles.size() * 6);
    for (std::size_t p = 0; p < angles.size(); ++p) {
        rotations[6 * p] = 0.5f * angles[p];  // the root's, which is not sampled
        rotations[6 * p + 3] = angles[p];
    }
    rig.clips = {clipOfRotations(rig, rotations, "known")};
    return rig;
}

TEST(JointLimits, ArePercentilesSoThatOneBadKeyDoesNotWidenThem) {
    std::vector<float> angles(201);
    for (std::size_t p = 0; p < 201; ++p) angles[p] = float(p) / 200;
    angles[7] = -3;
    const Rig rig = rigWithAngles(angles);
    const JointLimits limits = limitsOfFrames(rig, rigFrames(rig, sampleFrames(rig, {}, 0)), 2);
    // Sorted these are -3, 0, 0.005 ... without 0.035. The percentiles are the entries 2 and 198.
    EXPECT_NEAR(limits.low[3], 0.005, 1e-6);
    EXPECT_NEAR(limits.high[3], 0.99, 1e-6);
    for (const std::size_t c : {0u, 1u, 2u, 4u, 5u})
        EXPECT_NEAR(std::abs(limits.low[c]) + std::abs(limits.high[c]), 0, 1e-6);
}

// Without clips the joints below the root turn by 30 degrees / sqrt(depth), and never by less than 10.
TEST(JointLimits, WithoutClipsFallWithTheDepth) {
    Rig rig = readRig({sample("capsule_man.glb")});
    rig.clips.clear();
    const JointLimits limits = limitsWithoutClips(rig);
    int turning = 0;
    for (std::size_t c = 0; c < limits.high.size(); ++c) {
        int depth = 0;
        for (int up = rig.skin.parents[c / 3]; up >= 0; up = rig.skin.parents[std::size_t(up)]) ++depth;
        EXPECT_EQ(limits.low[c], -limits.high[c]);
        if (limits.high[c] == 0) continue;
        ++turning;
        EXPECT_NEAR(limits.high[c], std::max(30 / std::sqrt(depth), 10.0) * 3.14159265358979 / 180, 1e-9);
    }
    EXPECT_GT(turning, 3 * 5);
    EXPECT_EQ(limits.high[0], 0);
}

TEST(SamplePoses, FillTheLimitsAndKeepTheRoot) {
    const Rig rig = readRig({sample("capsule_man.glb")});
    const JointLimits limits = limitsOfFrames(rig, rigFrames(rig, sampleFrames(rig, {}, 5)), 2);
    const std::size_t width = limits.low.size(), count = 256;
    const std::vector<float> poses = samplePoses(rig, limits, count, 1);
    ASSERT_EQ(poses.size(), count * width);
    for (std::size_t c = 0; c < width; ++c) {
        double low = 1e9, high = -1e9, mean = 0;
        for (std::size_t p = 0; p < count; ++p) {
            low = std::min(low, double(poses[p * width + c]));
            high = std::max(high, double(poses[p * width + c]));
            mean += poses[p * width + c] / double(count);
        }
        const double range = limits.high[c] - limits.low[c];
        EXPECT_GE(low, limits.low[c] - 1e-6);
        EXPECT_LE(high, limits.high[c] + 1e-6);
        EXPECT_TRUE(range == 0 || rig.skin.parents[c / 3] >= 0);
        EXPECT_GE(high - low, 0.95 * range);
        EXPECT_NEAR(mean, (limits.low[c] + limits.high[c]) / 2, 0.05 * range + 1e-7);
    }
    const std::vector<float> fewer = samplePoses(rig, limits, 10, 1);
    EXPECT_TRUE(std::equal(fewer.begin(), fewer.end(), poses.begin()));
    EXPECT_NE(samplePoses(rig, limits, 10, 2), fewer);
}

class PoseFiles : public testing::Test {
protected:
    PoseFiles() { std::filesystem::create_directories(folder_); }
    ~PoseFiles() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("penumbra_poses_test" + std::to_string(::getpid()));
};

TEST_F(PoseFiles, LimitsFileReplacesTheAxesThatItNames) {
    const Rig rig = readRig({sample("bend.glb")});
    const std::string& joint = rig.skin.joint_names[1];
    JointLimits limits{std::vector<double>(6, -1), std::vector<double>(6, 1)};
    applyLimitsFile(write("ok.csv", "# elbow\njoint,axis,min,max\r\n" + joint + ",y,-90,30.5\n\n"), rig, limits);
    EXPECT_NEAR(limits.low[4], -M_PI / 2, 1e-12);
    EXPECT_NEAR(limits.high[4], 30.5 * M_PI / 180, 1e-12);
    EXPECT_EQ(limits.low[3], -1);
    EXPECT_EQ(limits.high[5], 1);
    const std::string head = "joint,axis,min,max\n";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", "joint,axis,min,max"},
        {"joint;axis;min;max\n", "line 1"},
        {head + "knee,x,0,1\n", "line 2: the rig has no joint 'knee'"},
        {head + joint + ",w,0,1\n", "axis 'w'"},
        {head + joint + ",xy,0,1\n", "axis 'xy'"},
        {head + joint + ",x,0,181\n", "'181'"},
        {head + joint + ",x,nan,1\n", "'nan'"},
        {head + joint + ",x,0,1deg\n", "'1deg'"},
        {head + joint + ",x,2,1\n", "min 2 is above max 1"},
        {head + joint + ",x,0,1\n" + joint + ",x,0,2\n", "line 3: this axis"},
        {head + joint + ",x\n", "line 2: not"},
    };
    for (const auto& [text, message] : wrong) {
        try {
            applyLimitsFile(write("wrong.csv", text), rig, limits);
            ADD_FAILURE() << text << " was accepted";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("wrong.csv"), testing::HasSubstr(message)));
        }
    }
    EXPECT_THROW(applyLimitsFile(folder_ / "none.csv", rig, limits), IoError);
    EXPECT_THROW(applyLimitsFile(folder_, rig, limits), IoError);
}

// --- The list -------------------------------------------------------------------------------------------------------

TEST(PoseList, NoHeldOutClipIsChosenNorGivesLimits) {
    PoseOptions options{.holdout = {"walk"}, .fps = 5, .choose = 32, .sample = 8};
    const PosePlan plan = planPoses({sample("capsule_man.glb")}, options);
    EXPECT_EQ(plan.candidates.clip_names, (std::vector<std::string>{"wave", "squat"}));
    ASSERT_EQ(plan.candidates.frameCount(), 32u);
    const PoseList list = makePoses(plan, options, 2);
    EXPECT_THAT(list.file.frames.clip_names, testing::Not(testing::Contains("walk")));
    std::vector<std::uint32_t> ranks(list.file.frames.frameCount());
    std::iota(ranks.begin(), ranks.end(), 0u);
    EXPECT_EQ(sorted(list.file.rank), ranks);
    options.holdout = {"wave", "squat"};
    options.choose = 16;
    EXPECT_NE(makePoses(planPoses({sample("capsule_man.glb")}, options), options, 2).limits.high, list.limits.high);
    options.clips = {"wave"};
    EXPECT_THROW(planPoses({sample("capsule_man.glb")}, options), UsageError);
    options.holdout = {"moonwalk"};
    EXPECT_THROW(planPoses({sample("capsule_man.glb")}, options), UsageError);
}

// Chosen and sampled poses go through the file into a bake, and through a rig. The poses are those of the source.
TEST_F(PoseFiles, BakesOfTheListAndOfTheRigHaveThePosesOfTheSource) {
    const PoseOptions options{.fps = 5, .choose = 6, .sample = 3};
    const PosePlan plan = planPoses({sample("capsule_man.glb")}, options);
    PoseList list = makePoses(plan, options, 2);
    list.file.provenance = makeProvenance("test", "{}", {});
    writePoseFile(folder_ / "x.poses.h5", list.file);
    writeGlb(folder_ / "x.glb", rigOfPoses(plan.rig, list.file), "");

    BakeOptions bake;
    bake.poses = folder_ / "x.poses.h5";
    bake.clips = {};
    const BakePlan from_list = planBake({sample("capsule_man.glb")}, bake);
    EXPECT_EQ(from_list.header.frames.clip_names.back(), "sampled");
    EXPECT_EQ(from_list.header.provenance.inputs.size(), 2u);
    const BakePlan from_rig = planBake({folder_ / "x.glb"}, {});
    ASSERT_EQ(from_list.header.frames.frameCount(), 9u);
    ASSERT_EQ(from_rig.header.frames.frameCount(), 9u);
    EXPECT_EQ(from_rig.header.frames.clip_names, std::vector<std::string>{"poses"});

    const auto positions = [](const Rig& rig, int clip, double time) {
        std::vector<Vec3> p, n;
        skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, clip, time).bones, p, n);
        return p;
    };
    for (std::size_t f = 0; f < 9; ++f) {
        const FrameList& frames = from_list.header.frames;
        const int clip = from_list.source_clip[frames.clip[f]];
        const std::vector<Vec3> a = positions(*from_list.source.rig, clip, frames.time[f]),
                                b = positions(*from_rig.source.rig, 0, double(f));
        EXPECT_LT(largestDistance(a, b), 1e-5 * from_list.rest_diagonal) << f;  // 2e-7 measured
        EXPECT_TRUE(f >= 6 || a == positions(plan.rig, clip, list.file.frames.time[f])) << f;
    }
}

TEST_F(PoseFiles, ListsOfOtherRigsAreRefused) {
    const PoseOptions options{.clips = {"walk"}, .fps = 5, .choose = 4, .sample = 3};
    const PosePlan plan = planPoses({sample("capsule_man.glb")}, options);
    PoseList list = makePoses(plan, options, 2);
    list.file.provenance = makeProvenance("test", "{}", {});
    const auto refusal = [&](const PoseFile& file, const char* rig) -> std::string {
        writePoseFile(folder_ / "x.poses.h5", file);
        BakeOptions bake;
        bake.poses = folder_ / "x.poses.h5";
        try {
            planBake({sample(rig)}, bake);
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal(list.file, "capsule_man.glb"), "accepted");
    EXPECT_THAT(refusal(list.file, "bend.glb"), testing::HasSubstr("no clip 'walk'"));
    PoseFile other = list.file;
    std::swap(other.joint_names[0], other.joint_names[1]);
    EXPECT_THAT(refusal(other, "capsule_man.glb"), testing::HasSubstr("/skin/joint_names"));
    other = list.file;
    other.frames.time[3] = 3.01;
    EXPECT_THAT(refusal(other, "capsule_man.glb"), testing::HasSubstr("beyond the end of clip 'walk'"));

    BakeOptions bake;  // the list, then further clips in full
    bake.poses = folder_ / "x.poses.h5";
    writePoseFile(*bake.poses, list.file);
    bake.clips = {"wave"};
    bake.fps = 1;
    const BakePlan both = planBake({sample("capsule_man.glb")}, bake);
    EXPECT_EQ(both.header.frames.clip_names, (std::vector<std::string>{"walk", "sampled", "wave"}));
    EXPECT_EQ(both.header.frames.frameCount(), 4u + 3 + 4);
    bake.clips = {"walk"};
    EXPECT_THROW(planBake({sample("capsule_man.glb")}, bake), UsageError);
}

}  // namespace
}  // namespace penumbra::test_poses
