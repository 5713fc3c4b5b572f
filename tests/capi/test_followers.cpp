// Vertices that follow points, through the C interface.
#include <gtest/gtest.h>

#include "runtime/evaluate/evaluator.h"
#include "tests/capi/packed_asset.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_dense.h"

namespace penumbra::test_followers {
namespace {

using namespace capi_test;

TEST(CApiFollowers, HaveWhatTheClassesGive) {
    Model model = synthetic::tubeModel({});
    synthetic::addDense(model);
    const std::vector<std::byte> bytes = packAsset(model, materials(), lights(3), {}, "{}", 1).bytes;
    const AssetView view = openAsset(bytes);
    const Asset asset = open(bytes);
    ASSERT_TRUE(asset);
    const penumbra_asset_info info = infoOf(asset);
    penumbra_followers followers{};
    ASSERT_EQ(penumbra_asset_get_followers(asset.get(), &followers), PENUMBRA_OK);
    EXPECT_EQ(followers.first, model.mesh.vertexCount());
    EXPECT_EQ(followers.first + followers.count, info.vertex_count);
    const Character who = character(asset);
    ASSERT_EQ(penumbra_character_set_frame(who.get(), 1, nullptr), PENUMBRA_OK);
    Frame frame(info);
    ASSERT_EQ(frame.evaluate(who.get(), info, 3), 0);
    for (const std::size_t begin : {std::size_t(0), followers.first + 5}) {  // in two ranges
        const std::size_t end = begin == 0 ? followers.first + 5 : info.vertex_count;
        const penumbra_vertices some = frame.vertices(begin, end - begin);
        ASSERT_EQ(penumbra_character_follow(who.get(), &some, nullptr), PENUMBRA_OK);
    }
    Evaluator evaluator(view);
    evaluator.setFrame(1);
    EXPECT_EQ(frame.coefficients, PosedArrays(evaluator).coefficients);
    const Shading shade = shading(asset);
    std::size_t length = 0;
    std::string text(1 << 20, '\0');
    ASSERT_EQ(penumbra_shading_get_glsl(shade.get(), text.data(), text.size(), &length, nullptr), PENUMBRA_OK);
    EXPECT_NE(text.find("void penumbra_add_point("), std::string::npos);
}

TEST(CApiFollowers, OtherAssetsHaveNone) {
    const Asset asset = open(packed());
    penumbra_followers followers{1, 1, nullptr, nullptr};
    ASSERT_EQ(penumbra_asset_get_followers(asset.get(), &followers), PENUMBRA_OK);
    EXPECT_EQ(followers.count, 0u);
    EXPECT_EQ(penumbra_asset_get_followers(asset.get(), nullptr), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra::test_followers
