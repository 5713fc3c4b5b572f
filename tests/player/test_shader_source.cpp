#include <gtest/gtest.h>

#include <random>

#include "player/runtime/light_lobes.h"
#include "player/sh_glsl.h"
#include "player/shader_source.h"
#include "sh/sh_basis.h"
#include "tests/player/synthetic_asset.h"

namespace penumbra {
namespace {

// Worst of the 8 orders: 8e-6 of the light's size.
TEST(LightLobes, SumToTheLight) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (int order = 1; order <= kMaxOrder; ++order) {
        std::vector<float> sh(std::size_t(3 * coefficientCount(order)));
        for (float& c : sh) c = normal(random);
        const LightLobes lobes = makeLightLobes({"random", order, sh});
        std::vector<float> sum(sh.size()), basis(std::size_t(coefficientCount(order)));
        for (std::size_t d = 0; d < lobes.directions.size(); ++d) {
            evalBasis(order, lobes.directions[d], basis);
            for (std::size_t i = 0; i < basis.size(); ++i)
                for (int c = 0; c < 3; ++c)
                    sum[3 * i + std::size_t(c)] +=
                        lobes.weights[d * std::size_t(order) + std::size_t(bandOfIndex(int(i)))][c] * basis[i];
        }
        for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(sum[i], sh[i], 3e-5) << "order " << order;
    }
}

TEST(ShGlsl, LiteralsAreFloatsAndReadBack) {
    EXPECT_EQ(glslFloat(1), "1.0");
    EXPECT_EQ(glslFloat(0.5), "0.5");
    EXPECT_EQ(glslFloat(-2), "(-2.0)");
    EXPECT_EQ(glslFloat(1e-9), "1e-09");
    for (const float value : {0.1f, 1.0f / 3, 1.23456789e-20f, 3.0e30f}) {
        const std::string text = glslFloat(value);
        EXPECT_EQ(std::stof(text), value) << text;
    }
}

TEST(ShaderSource, IsotropicSlicesCoupleEqualOrdersOnly) {
    const player_test::SyntheticAsset data;
    // Per m: 5 - |m| bands in, times the bands out with l+m even: 15 + 2 (8 + 6 + 2 + 1).
    const SliceLayout ggx = sliceLayout(data.asset.materials[1]);
    EXPECT_EQ(ggx.entries.size(), 49u);
    const SliceLayout lambert = sliceLayout(data.asset.materials[0]);
    for (const SliceLayout::Entry& entry : lambert.entries)
        EXPECT_EQ(entry.e, 0) << "Lambert is the same from anywhere";
    EXPECT_EQ(sliceLayout(data.asset.materials[2]).channels, 3);
}

TEST(ShaderSource, MaterialsOfOneLayoutShareTheText) {
    const player_test::SyntheticAsset data;
    ShaderRecipe recipe;
    recipe.convention = data.asset.model.convention;
    recipe.stride = data.asset.model.stride;
    recipe.influences = 2;
    recipe.light_order = 4;
    recipe.slices = sliceLayout(data.asset.materials[1]);
    MaterialView scaled = data.asset.materials[1];
    std::vector<float> slices(scaled.slices.begin(), scaled.slices.end());
    for (float& c : slices) c *= 0.5f;
    scaled.slices = slices;
    ShaderRecipe other = recipe;
    other.slices = sliceLayout(scaled);
    EXPECT_EQ(evaluateVertexSource(recipe), evaluateVertexSource(other));
    EXPECT_EQ(evaluateVertexSource(recipe).find("GENERATED\n"), std::string::npos);
}

}  // namespace
}  // namespace penumbra
