#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "bake/visibility/bake_visibility.h"
#include "formats/common/errors.h"
#include "formats/source/source_readers.h"
#include "tests/bake/shapes.h"
#include "tests/difference.h"

namespace penumbra::test_bake_visibility {

namespace {

std::filesystem::path sample(const std::string& name) {
    return std::filesystem::path(PENUMBRA_BINARY_DIR) / ".." / "samples" / name;
}

// Has a folder of its own, which it removes at the end.
class BakeVisibility : public testing::Test {
protected:
    BakeVisibility() { std::filesystem::create_directories(folder_); }
    ~BakeVisibility() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path out(const std::string& name) const { return folder_ / name; }
    std::string bake(const std::string& rig, const BakeOptions& options, int threads) const {
        bakeVisibility(planBake({sample(rig)}, options), options, {out("x.vis.h5")}, threads, ProgressStyle::kNone);
        std::ifstream in(out("x.vis.h5"), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("penumbra_bake_test" + std::to_string(::getpid()));
};

}  // namespace

// A convex solid sees its whole sky, and the same solid with its triangles turned around sees none of it.
TEST_F(BakeVisibility, OpenShareTellsASolidThatIsInsideOut) {
    for (const bool inside_out : {false, true}) {
        const std::filesystem::path path = out("octahedron.obj");
        std::ofstream obj(path);
        obj << "v 1 0 0\nv 0 1 0\nv 0 0 1\nv -1 0 0\nv 0 -1 0\nv 0 0 -1\n";
        for (const char* face : {"1 2 3", "4 3 2", "4 5 3", "1 3 5", "1 6 2", "4 2 6", "4 6 5", "1 5 6"})
            obj << "f " << (inside_out ? std::string(face).assign({face[4], ' ', face[2], ' ', face[0]}) : face)
                << '\n';
        obj.close();
        BakeOptions options;
        options.rays = 64;
        const BakePlan plan = planBake({path}, options);
        const BakeResult result = bakeVisibility(plan, options, {out("x.vis.h5")}, 1, ProgressStyle::kNone);
        EXPECT_NEAR(result.open_share, inside_out ? 0 : 1, 0.02);
    }
}

TEST_F(BakeVisibility, SameBytesForAnyThreadCount) {
    BakeOptions options;
    options.rays = 64;
    options.fps = 2;
    const std::string expected = bake("capsule_man.glb", options, 1);
    ASSERT_GT(expected.size(), 100000u);
    for (const int threads : {2, 8}) EXPECT_TRUE(bake("capsule_man.glb", options, threads) == expected) << threads;
}

TEST_F(BakeVisibility, FramesAreThoseOfTheRig) {
    BakeOptions options;
    options.rays = 32;
    options.order = 3;
    options.fps = 2;
    options.clips = {"walk", "wave"};
    bake("capsule_man.glb", options, 2);
    const VisibilityReader reader(out("x.vis.h5"));
    const VisibilityHeader& header = reader.header();
    EXPECT_EQ(header.frames.clip_names, options.clips);
    ASSERT_EQ(header.frames.frameCount(), 14u);  // two clips of 3 s, both ends included
    EXPECT_EQ(header.frames.time[8], 0.5);
    EXPECT_EQ(header.rays, 32);
    EXPECT_EQ(header.order, 3);
    const Rig rig = readRig({sample("capsule_man.glb")});
    int wave = 0;
    while (rig.clips[std::size_t(wave)].name != "wave") ++wave;
    const RigPose pose = evaluatePose(rig, wave, 0.5);
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, pose.bones, positions, normals);
    const VisibilityFrame frame = reader.readFrame(8);
    EXPECT_EQ(frame.positions, positions);
    EXPECT_EQ(frame.normals, normals);
    EXPECT_EQ(frame.bones, pose.bones);
    EXPECT_EQ(frame.pose, pose.pose);
    ASSERT_EQ(frame.coefficients.size(), positions.size() * 9);
}

TEST_F(BakeVisibility, FrameRangeIsASliceOfTheWhole) {
    BakeOptions options;
    options.rays = 32;
    options.order = 2;
    options.fps = 2;
    bake("capsule_man.glb", options, 2);
    std::filesystem::rename(out("x.vis.h5"), out("whole.vis.h5"));
    options.frames = parseFrameRange("5:12:3");
    bake("capsule_man.glb", options, 2);
    const VisibilityReader whole(out("whole.vis.h5")), part(out("x.vis.h5"));
    ASSERT_EQ(part.header().frames.frameCount(), 3u);
    EXPECT_EQ(part.header().frames.clip_names, whole.header().frames.clip_names);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(part.header().frames.clip[i], whole.header().frames.clip[5 + 3 * i]);
        EXPECT_EQ(part.readFrame(i).coefficients, whole.readFrame(5 + 3 * i).coefficients);
    }
    options.frames = parseFrameRange("0:1000");
    EXPECT_THROW(planBake({sample("capsule_man.glb")}, options), UsageError);
}

TEST_F(BakeVisibility, HalfPrecisionIsCloseToSingle) {
    bake("bend.glb", {.clips = {"bend"}, .fps = 1, .rays = 64}, 2);
    const VisibilityFrame single = VisibilityReader(out("x.vis.h5")).readFrame(1);
    bake("bend.glb", {.clips = {"bend"}, .fps = 1, .rays = 64, .precision = Precision::kFloat16}, 2);
    const VisibilityFrame half = VisibilityReader(out("x.vis.h5")).readFrame(1);
    // fp16 rounds by at most 2^-11 of the value.
    EXPECT_LT(relativeDifference(half.coefficients, single.coefficients), 4.9e-4);
    EXPECT_EQ(half.positions, single.positions);
}

TEST_F(BakeVisibility, PoseThatIsNotFiniteIsAnErrorThatNamesTheFrame) {
    const BakeOptions options{.clips = {"bend"}, .fps = 1, .rays = 64};
    BakePlan plan = planBake({sample("bend.glb")}, options);
    plan.source.rig->mesh.rest_positions[5].x = std::nanf("");
    try {
        bakeVisibility(plan, options, {out("x.vis.h5")}, 2, ProgressStyle::kNone);
        FAIL() << "no error";
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("bend.glb"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("frame 0"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST(BakeOptions, FrameRangeTakesTwoOrThreeNumbers) {
    const FrameRange range = parseFrameRange("2:10:3");
    EXPECT_EQ(range.begin, 2u);
    EXPECT_EQ(range.end, 10u);
    EXPECT_EQ(range.step, 3u);
    EXPECT_EQ(parseFrameRange("0:1").step, 1u);
    for (const char* bad : {"", "3", "3:", ":3", "3:3", "4:3", "0:4:0", "0:4:1:2", "a:b", "0:4x", "-1:4", "0 :4"})
        EXPECT_THROW(parseFrameRange(bad), std::invalid_argument) << bad;
}

}  // namespace penumbra::test_bake_visibility
