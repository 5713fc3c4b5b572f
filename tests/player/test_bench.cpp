#include <gtest/gtest.h>

#include "pack/pack_asset.h"
#include "player/bench/bench.h"
#include "tests/runtime/synthetic_asset.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_bench {
namespace {

RenderOptions smallPicture() {
    RenderOptions options;
    options.width = options.height = 32;
    return options;
}

TEST(Bench, TimesEveryStage) {
    const player_test::SyntheticAsset data({.precision = AssetPrecision::kI8, .rings = 8});
    const BenchResult result = benchAsset(smallPicture(), data.asset, 3, 2);
    EXPECT_EQ(result.vertices, data.asset.mesh.positions.size());
    EXPECT_EQ(result.triangles, data.asset.mesh.triangles.size() / 3);
    ASSERT_EQ(result.cpu.stages.size(), 6u);
    for (const CpuStage& stage : result.cpu.stages) {
        EXPECT_GT(stage.time.best, 0) << stage.name;
        EXPECT_GE(stage.time.median, stage.time.best) << stage.name;
        EXPECT_GT(stage.roof, 0) << stage.name;
        EXPECT_GT(stage.work.flop, 0) << stage.name;
    }
    for (const double ms :
         {result.cpu.pose_evaluate.median, result.cpu.pose_skin_evaluate.median, result.cpu.shade.median,
          result.cpu.frame.median, result.gl.draw_values, result.gl.draw_model, result.gl.first_frame})
        EXPECT_GT(ms, 0);
    ASSERT_EQ(result.gl.whole_frames.size(), 2u);
    EXPECT_EQ(result.gl.whole_frames[0].samples, 1);
    EXPECT_EQ(result.gl.whole_frames[1].samples, 4);
    EXPECT_LT(result.gl.path_difference, 0.5) << "8-bit steps";
    EXPECT_GT(result.gl.model.evaluate, 0);
    EXPECT_GT(result.gl.model.bytes_uploaded, 12 * sizeof(float) * data.asset.animation.jointCount());
}

TEST(Bench, TimesTheFarPartsOfAComposedAsset) {
    const std::vector<BrdfFile> brdfs = {synthetic::lambert()};
    const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
    const Packed packed =
        packAsset(synthetic::composedTube(), brdfs, lights, {.precision = AssetPrecision::kI8}, "{}", 1);
    const AssetView asset = openAsset(packed.bytes);
    const BenchResult result = benchAsset(smallPicture(), asset, 2, 2, {2});
    ASSERT_EQ(result.cpu.stages.size(), 9u);
    EXPECT_EQ(std::string(result.cpu.stages[3].name), "far");
    for (const CpuStage& stage : result.cpu.stages) {
        EXPECT_GT(stage.time.best, 0) << stage.name;
        EXPECT_EQ(stage.counted(), std::string(stage.name) != "evaluate, fast") << stage.name;
    }
    EXPECT_LT(result.gl.path_difference, 0.5) << "8-bit steps";
    EXPECT_GT(result.characters.back().glsl.evaluate, 0);
}

TEST(Bench, DrawsAmbientWhereThereIsNoMaterial) {
    player_test::SyntheticAsset data({.rings = 8});
    data.asset.materials.clear();
    const BenchResult result = benchAsset(smallPicture(), data.asset, 1, 1);
    EXPECT_EQ(result.cpu.shade.median, 0);
    EXPECT_EQ(result.cpu.stages.size(), 5u);
    EXPECT_GT(result.gl.draw_model, 0);
}

// A character has as results 3 Vec3, 16 numbers and the radiance for each vertex. Its evaluator comes on top.
TEST(Bench, CharactersShareTheModel) {
    const player_test::SyntheticAsset data({.precision = AssetPrecision::kI8});
    const BenchResult result = benchAsset(smallPicture(), data.asset, 1, 2, {7, 7});
    ASSERT_EQ(result.characters.size(), 2u);
    EXPECT_EQ(result.characters[0].count, 1) << "what the others are compared with";
    const std::size_t results = data.asset.mesh.positions.size() * (4 * sizeof(Vec3) + 16 * 4);
    for (const CharactersCost& c : result.characters) {
        EXPECT_GT(c.cpu(), 0);
        EXPECT_GT(c.draw, 0);
        EXPECT_EQ(c.glsl.characters, std::size_t(c.count));
        EXPECT_GT(c.glsl.evaluate, 0);
        EXPECT_GT(c.glsl.draw, 0);
        EXPECT_EQ(c.glsl.bytes_shared, result.characters[0].glsl.bytes_shared);
        EXPECT_NEAR(double(c.glsl.bytes_each), double(result.characters[0].glsl.bytes_each), 3 * 256);
        if (c.bytes_each == 0) continue;  // another allocator
        EXPECT_GT(c.bytes_each, results);
        EXPECT_LT(c.bytes_each, results + 16384);
    }
    EXPECT_EQ(result.characters[1].count, 7);
}

// D5 has 15 numbers padded to 16. The mean is in halves, the 6 components are in bytes, and the results are floats.
TEST(StageWork, EvaluationReadsTheModelOnceAndWritesTheNumbers) {
    const player_test::SyntheticAsset data({.precision = AssetPrecision::kI8, .rings = 8});
    const std::size_t vertices = data.asset.mesh.positions.size(), clusters = data.asset.model.clusters.size();
    const StageWork work = evaluateWork(data.asset);
    EXPECT_EQ(work.read, vertices * 16 * (2 + 6) + clusters * 6 * 4);
    EXPECT_EQ(work.written, vertices * 16 * 4);
    EXPECT_EQ(work.flop, double(vertices) * 16 * 6 * 2);
}

TEST(Roofline, LowerOfPeakAndBandwidth) {
    Roofline roofline;
    roofline.peak = 100;
    const Bandwidth memory{1 << 20, 40, 50};
    EXPECT_EQ(attainable(roofline, memory, 1), 50);
    EXPECT_EQ(attainable(roofline, memory, 2), 100);
    EXPECT_EQ(attainable(roofline, memory, 8), 100);
}

// Whatever else runs, no processor of today does less.
TEST(Roofline, MeasuresEveryWorkingSetForAnyThreadCount) {
    for (int threads : {1, 2, 5}) {
        const Roofline roofline = measureRoofline(threads, {100000, 1 << 20});
        EXPECT_EQ(roofline.threads, threads);
        EXPECT_GT(roofline.peak, 0.1);
        ASSERT_EQ(roofline.memory.size(), 2u);
        for (const Bandwidth& memory : roofline.memory) {
            EXPECT_GT(memory.read, 0.05);
            EXPECT_GT(memory.triad, 0.05);
        }
    }
}

}  // namespace
}  // namespace penumbra::test_bench
