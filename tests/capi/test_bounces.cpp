// Light that bounces through the C interface: its numbers, the radiance it adds, and the ambient term with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capi/packed_asset.h"
#include "tests/player/count_allocations.h"
#include "tests/synthetic_indirect.h"

namespace penumbra {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

struct LitAsset {
    std::vector<std::byte> bytes = packAsset(synthetic::litTube({}), materials(), lights(3), {}, "{}", 1).bytes;
    Asset asset = open(bytes);
    penumbra_asset_info info = infoOf(asset);
    Shading shading = capi_test::shading(asset, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4});
    Frame frame{info};
    std::vector<float> bounced = std::vector<float>(info.vertex_count * PENUMBRA_BOUNCED_STRIDE);

    LitAsset() {
        const Character posed = character(asset);
        frame.evaluate(posed.get(), info);
        EXPECT_EQ(penumbra_character_evaluate_bounced(posed.get(), 0, info.cluster_count, bounced.data(), nullptr),
                  PENUMBRA_OK);
    }
    std::vector<float> radiance(penumbra_bounces bounces, const float* indirect) {
        const penumbra_vertices vertices{frame.positions.data(), frame.normals.data(), frame.tangents.data(),
                                         frame.numbers.data()};
        const float eye[3] = {0, 1, 4};
        std::vector<float> out(3 * info.vertex_count);
        EXPECT_EQ(penumbra_shading_set_bounces(shading.get(), bounces, nullptr), PENUMBRA_OK);
        const std::size_t before = allocationCount();
        EXPECT_EQ(penumbra_shading_shade_bounced(shading.get(), eye, 0, info.vertex_count, &vertices, indirect,
                                                 out.data(), nullptr),
                  PENUMBRA_OK);
        EXPECT_EQ(allocationCount(), before);
        return out;
    }
};

TEST(CApiBounces, AllLightIsDirectAndBouncedLight) {
    LitAsset lit;
    EXPECT_EQ(penumbra_asset_bounces(lit.asset.get()), 3);
    const std::vector<float> both = lit.radiance(PENUMBRA_ALL_LIGHT, lit.bounced.data()),
                             direct = lit.radiance(PENUMBRA_DIRECT_LIGHT, lit.bounced.data()),
                             bounced = lit.radiance(PENUMBRA_BOUNCED_LIGHT, lit.bounced.data());
    EXPECT_EQ(lit.radiance(PENUMBRA_ALL_LIGHT, nullptr), direct);
    float most = 0;
    for (std::size_t i = 0; i < both.size(); ++i) {
        EXPECT_NEAR(both[i], direct[i] + bounced[i], 1e-5);
        most = std::max(most, bounced[i]);
    }
    EXPECT_GT(most, 0.01f);
}

TEST(CApiBounces, AmbientWithBouncesIsNotBelowAmbientWhereSurfacesReflect) {
    LitAsset lit;
    const Character posed = character(lit.asset);
    std::vector<float> plain(lit.info.vertex_count), bounced(plain.size());
    ASSERT_EQ(penumbra_character_ambient(posed.get(), 0, plain.size(), lit.frame.numbers.data(), plain.data(), nullptr),
              PENUMBRA_OK);
    ASSERT_EQ(penumbra_character_ambient_bounced(posed.get(), 0, plain.size(), lit.frame.numbers.data(),
                                                 lit.bounced.data(), bounced.data(), nullptr),
              PENUMBRA_OK);
    for (std::size_t v = 0; v < plain.size(); ++v) {
        if (lit.bounced[v * PENUMBRA_BOUNCED_STRIDE] < 0.2f) continue;
        EXPECT_GE(bounced[v] + 1e-6f, plain[v]);
        EXPECT_LE(bounced[v], 1.0f);
    }
}

TEST(CApiBounces, AssetsWithoutItAndWrongCallsAreRefused) {
    const std::vector<std::byte> bytes = packAsset(synthetic::tubeModel({}), materials(), lights(3), {}, "{}", 1).bytes;
    const Asset plain = open(bytes);
    EXPECT_EQ(penumbra_asset_bounces(plain.get()), 0);
    EXPECT_EQ(penumbra_asset_bounces(nullptr), 0);
    penumbra_error error;
    float one = 0;
    EXPECT_EQ(penumbra_character_evaluate_bounced(character(plain).get(), 0, 1, &one, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no light that bounces"));
    LitAsset lit;
    EXPECT_EQ(penumbra_character_evaluate_bounced(character(lit.asset).get(), 0, lit.info.cluster_count + 1,
                                                  lit.bounced.data(), &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_set_bounces(lit.shading.get(), penumbra_bounces(3), &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_set_bounces(nullptr, PENUMBRA_ALL_LIGHT, &error), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra
