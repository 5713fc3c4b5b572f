// Light that bounces through the C interface: its numbers, the radiance it adds, and the ambient term with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/capi/packed_asset.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_bounces {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

struct LitAsset {
    std::vector<std::byte> bytes = packAsset(synthetic::litTube({}), materials(), lights(3), {}, "{}", 1).bytes;
    Asset asset = open(bytes);
    penumbra_asset_info info = infoOf(asset);
    Shading shading = capi_test::shading(asset, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4});
    Frame frame{info};

    LitAsset() {
        frame.bounced.resize(info.vertex_count * PENUMBRA_BOUNCED_STRIDE);
        EXPECT_EQ(frame.evaluate(character(asset).get(), info), PENUMBRA_OK);
    }
    std::vector<float> radiance(penumbra_bounces bounces) {
        EXPECT_EQ(penumbra_shading_set_bounces(shading.get(), bounces, nullptr), PENUMBRA_OK);
        const std::size_t before = allocationCount();
        EXPECT_EQ(frame.shade(shading.get(), 0, info.vertex_count), PENUMBRA_OK);
        EXPECT_EQ(allocationCount(), before);
        return frame.radiance;
    }
};

TEST(CApiBounces, AllLightIsDirectAndBouncedLight) {
    LitAsset lit;
    EXPECT_EQ(penumbra_asset_bounces(lit.asset.get()), 3);
    const std::vector<float> both = lit.radiance(PENUMBRA_ALL_LIGHT), direct = lit.radiance(PENUMBRA_DIRECT_LIGHT),
                             bounced = lit.radiance(PENUMBRA_BOUNCED_LIGHT);
    lit.frame.bounced.clear();
    EXPECT_EQ(lit.radiance(PENUMBRA_ALL_LIGHT), direct);
    for (std::size_t i = 0; i < both.size(); ++i) EXPECT_NEAR(both[i], direct[i] + bounced[i], 1e-5);
    EXPECT_GT(largestOf(bounced), 0.01);
}

TEST(CApiBounces, AmbientWithBouncesIsNotBelowAmbientWhereSurfacesReflect) {
    LitAsset lit;
    Frame alone = lit.frame;
    alone.bounced.clear();
    EXPECT_EQ(alone.evaluate(character(lit.asset).get(), lit.info), PENUMBRA_OK);
    const std::vector<float>&plain = alone.ambient, &bounced = lit.frame.ambient;
    for (std::size_t v = 0; v < plain.size(); ++v) {
        if (lit.frame.bounced[v * PENUMBRA_BOUNCED_STRIDE] < 0.2f) continue;
        EXPECT_GE(bounced[v] + 1e-6f, plain[v]);
        EXPECT_LE(bounced[v], 1.0f);
    }
}

// A posed character whose parts have fields, so that it casts, and which light bounces to.
struct LitCaster {
    std::vector<std::byte> bytes;
    Asset asset;
    penumbra_asset_info info;
    Character one, other;
    Frame frame;

    static std::vector<std::byte> packed() {
        Model model = synthetic::composedTube(
            {.rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4});
        synthetic::addIndirect(model);
        return packAsset(model, {}, {}, {}, "{}", 1).bytes;
    }
    LitCaster()
        : bytes(packed()),
          asset(open(bytes)),
          info(infoOf(asset)),
          one(character(asset)),
          other(character(asset)),
          frame(info) {
        frame.bounced.resize(info.vertex_count * PENUMBRA_BOUNCED_STRIDE);
        EXPECT_EQ(frame.evaluate(one.get(), info), PENUMBRA_OK);
    }
    // Returns for each vertex the factor between two arrays of light that bounces. All numbers of a vertex have the
    // same.
    std::vector<float> sharesIn(const std::vector<float>& cast) const {
        std::vector<float> shares;
        for (std::size_t v = 0; v < info.vertex_count; ++v) {
            const float* before = &frame.bounced[v * PENUMBRA_BOUNCED_STRIDE];
            const float* after = &cast[v * PENUMBRA_BOUNCED_STRIDE];
            shares.push_back(after[0] / before[0]);
            for (std::size_t i = 0; i < PENUMBRA_BOUNCED_STRIDE; ++i)
                EXPECT_NEAR(after[i], shares.back() * before[i], 1e-5) << "vertex " << v << ", number " << i;
        }
        return shares;
    }
};

// The share is that of probes at the vertices: 2e-7 apart at most, as these casters are near, where no anchors serve.
TEST(CApiBounces, CastersLeaveTheShareOfAWhiteSkyThatTheyLeave) {
    LitCaster lit;
    const penumbra_asset* casters[] = {lit.asset.get(), lit.asset.get()};
    penumbra_scene* made = nullptr;
    ASSERT_EQ(penumbra_scene_create(casters, 2, &made, nullptr), PENUMBRA_OK);
    const Scene scene(made);
    const float beside[12] = {1, 0, 0, 0.6f, 0, 1, 0, 0, 0, 0, 1, 0},
                away[12] = {1, 0, 0, 5000, 0, 1, 0, 0, 0, 0, 1, 0};
    Frame cast = lit.frame, plain = lit.frame;
    plain.bounced.clear();
    const auto castFrom = [&](const float* place, Frame& frame) {
        const penumbra_vertices vertices = frame.vertices();
        EXPECT_EQ(penumbra_scene_set_caster(scene.get(), 1, lit.other.get(), place, nullptr), PENUMBRA_OK);
        EXPECT_EQ(penumbra_scene_cast(scene.get(), 0, lit.one.get(), nullptr, &vertices, nullptr), PENUMBRA_OK);
    };
    castFrom(away, cast);
    EXPECT_EQ(cast.bounced, lit.frame.bounced) << "nobody is in reach";
    castFrom(beside, cast);
    castFrom(beside, plain);
    EXPECT_EQ(cast.coefficients, plain.coefficients) << "visibility is cast on as without bounces";
    std::vector<float> e(lit.info.vertex_count);
    const penumbra_points points{lit.frame.positions.data(), lit.frame.normals.data(), e.size()};
    EXPECT_EQ(penumbra_scene_ambient(scene.get(), 0, &points, e.data(), nullptr), PENUMBRA_OK);
    const std::vector<float> shares = lit.sharesIn(cast.bounced);
    for (std::size_t v = 0; v < e.size(); ++v) EXPECT_NEAR(shares[v], e[v], 1e-5) << v;
    EXPECT_LT(*std::min_element(shares.begin(), shares.end()), 0.8f);
}

// Above a level field without end a surface sees (1 + cos) / 2 of a white sky, where cos is between its normal and up.
// The tube lies across, so that its normals point up, down and to all sides. The share is off by 0.0041 at most.
TEST(CApiBounces, GroundLeavesTheShareOfAWhiteSkyThatItLeaves) {
    LitCaster lit;
    const penumbra_heights_options options = {16, 16, 1, 1, {-8, -1, -8}, PENUMBRA_BORDER_CLAMPED, 0, 0};
    const std::vector<float> level(256);
    const float across[12] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0};
    penumbra_heights* made = nullptr;
    ASSERT_EQ(penumbra_heights_create(&options, level.data(), &made, nullptr), PENUMBRA_OK);
    const std::unique_ptr<penumbra_heights, decltype(&penumbra_heights_destroy)> field(made, penumbra_heights_destroy);
    Frame cast = lit.frame, plain = lit.frame;
    plain.bounced.clear();
    for (Frame* frame : {&cast, &plain}) {
        const penumbra_vertices vertices = frame->vertices();
        EXPECT_EQ(penumbra_heights_shadow(field.get(), lit.one.get(), across, &vertices, nullptr), PENUMBRA_OK);
    }
    EXPECT_EQ(cast.coefficients, plain.coefficients);
    const std::vector<float> shares = lit.sharesIn(cast.bounced);
    for (std::size_t v = 0; v < shares.size(); ++v)
        EXPECT_NEAR(shares[v], (1 - lit.frame.normals[3 * v]) / 2, 0.01) << v;
}

TEST(CApiBounces, AssetsWithoutItAndWrongCallsAreRefused) {
    const std::vector<std::byte> bytes = packAsset(synthetic::tubeModel({}), materials(), lights(3), {}, "{}", 1).bytes;
    const Asset plain = open(bytes);
    EXPECT_EQ(penumbra_asset_bounces(plain.get()), 0);
    EXPECT_EQ(penumbra_asset_bounces(nullptr), 0);
    penumbra_error error;
    float one = 0;
    const penumbra_vertices vertices{&one, &one, &one, &one, &one, 0, 0, &one};
    EXPECT_EQ(penumbra_character_evaluate(character(plain).get(), 0, 1, &vertices, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no light that bounces"));
    penumbra_scene* made = nullptr;
    ASSERT_EQ(penumbra_scene_create(nullptr, 0, &made, nullptr), PENUMBRA_OK);
    const Scene nobody(made);
    EXPECT_EQ(penumbra_scene_cast(nobody.get(), PENUMBRA_NONE, character(plain).get(), nullptr, &vertices, &error),
              PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no light that bounces"));
    LitAsset lit;
    EXPECT_EQ(penumbra_shading_set_bounces(lit.shading.get(), penumbra_bounces(3), &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_set_bounces(nullptr, PENUMBRA_ALL_LIGHT, &error), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra::test_bounces
