#include <gtest/gtest.h>

#include <random>

#include "player/draw/shader_source.h"
#include "runtime/glsl/sh_glsl.h"
#include "runtime/shade/exact_light_lobes.h"
#include "sh/sh_basis.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_shader_source {
namespace {

// The worst of the 8 orders has 8e-6 of the light's size.
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

TEST(ShadingLayout, IsotropicSlicesCoupleEqualOrdersOnly) {
    player_test::SyntheticAsset data;
    data.asset.materials = {data.asset.materials[1]};
    const ShadingSet ggx(data.asset);
    // For each m there are 5 - |m| bands in, times the bands out with l+m even: 15 + 2 (8 + 6 + 2 + 1).
    EXPECT_EQ(shadingLayout(ggx).views.size(), 49u);
    const player_test::SyntheticAsset other;
    data.asset.materials = {other.asset.materials[0]};
    for (const ShadingLayout::View& view : shadingLayout(ShadingSet(data.asset)).views)
        EXPECT_EQ(view.e, 0) << "Lambert is the same from anywhere";
}

// One program serves a whole asset: it has the union of its materials, and the highest order and the most channels of
// all.
TEST(ShadingLayout, HoldsEveryMaterialAndLight) {
    const player_test::SyntheticAsset data({.light_order = 6});
    for (const Reflectance reflectance : {Reflectance::kSlices, Reflectance::kOperators}) {
        const ShadingSet set(data.asset, {reflectance, LightForm::kFixed});
        const ShadingLayout layout = shadingLayout(set);
        EXPECT_EQ(layout.channels, 3);
        EXPECT_EQ(layout.light_order, 6);
        EXPECT_EQ(layout.lobe_count, 11);
        const std::vector<float> coefficients = materialData(layout, set);
        EXPECT_EQ(coefficients.size(), 3 * 4 * layout.materialTexels());
        for (std::size_t m = 0; m < 3; ++m) {
            std::size_t expected = 0, found = 0;
            for (const ViewTerm& term : viewTerms(data.asset.materials[m], reflectance, 0)) expected += term.value != 0;
            for (std::size_t i = 0; i < layout.views.size(); ++i)
                found += coefficients[4 * (m * layout.materialTexels() + 1 + i)] != 0;
            EXPECT_EQ(found, expected) << "material " << m;
        }
    }
}

TEST(ShaderSource, MaterialsOfOneStructureHaveOneText) {
    player_test::SyntheticAsset data;
    const MaterialView ggx = data.asset.materials[1];
    std::vector<float> half(ggx.slices.begin(), ggx.slices.end());
    for (float& c : half) c *= 0.5f;
    const auto text = [&](std::vector<MaterialView> materials) {
        data.asset.materials = std::move(materials);
        const ShadingLayout layout = shadingLayout(ShadingSet(data.asset));
        ShaderRecipe recipe{
            .convention = data.asset.model.convention, .stride = 16, .influences = 2, .shading = &layout};
        return evaluateSource(recipe);
    };
    MaterialView scaled = ggx;
    scaled.slices = half;
    const std::string one = text({ggx});
    EXPECT_EQ(one, text({scaled, ggx}));
    EXPECT_EQ(one.find("GENERATED_BY"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test_shader_source
