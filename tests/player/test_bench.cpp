#include <gtest/gtest.h>

#include "player/bench.h"
#include "tests/player/synthetic_asset.h"

namespace penumbra {
namespace {

TEST(Bench, TimesEveryStage) {
    const player_test::SyntheticAsset data({.precision = AssetPrecision::kI8, .rings = 8});
    RenderOptions options;
    options.width = options.height = 32;
    const BenchResult result = benchAsset(options, data.asset, 3, 2);
    EXPECT_EQ(result.vertices, data.asset.mesh.positions.size());
    EXPECT_EQ(result.triangles, data.asset.mesh.triangles.size() / 3);
    EXPECT_EQ(result.bytes_read, result.vertices * 16 * (2 + 6)) << "D5 padded to 16: f16 mean, 6 components of bytes";
    for (const double ms :
         {result.skin, result.evaluate, result.shade, result.draw_values, result.draw_model, result.first_frame})
        EXPECT_GT(ms, 0);
}

TEST(Bench, DrawsAmbientWhereThereIsNoMaterial) {
    player_test::SyntheticAsset data({.rings = 8});
    data.asset.materials.clear();
    RenderOptions options;
    options.width = options.height = 32;
    const BenchResult result = benchAsset(options, data.asset, 1, 1);
    EXPECT_EQ(result.shade, 0);
    EXPECT_GT(result.draw_model, 0);
}

}  // namespace
}  // namespace penumbra
