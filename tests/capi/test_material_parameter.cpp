// Live materials and the sides of a sheet through the C interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capi/packed_asset.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_material_parameter {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

std::vector<std::byte> liveAsset(const char* text) {
    BrdfFile live;
    live.name = "live";
    live.slice_order = live.view_order = 1;
    live.even_index = {0};
    live.lobes = {lobeOf(parseBrdf(text))};
    return packAsset(synthetic::tubeModel({}), std::vector<BrdfFile>{synthetic::lambert(), live}, lights(3), {}, "{}",
                     1)
        .bytes;
}

constexpr std::size_t kLive = 1;

TEST(CApiParameter, ChangesTheNextFrameAndMakesNothing) {
    const std::vector<std::byte> bytes = liveAsset("phong-live:exponent=5"),
                                 other = liveAsset("phong-live:exponent=60");
    const Asset asset = open(bytes), made = open(other);
    const penumbra_asset_info info = infoOf(asset);
    const Shading shading = capi_test::shading(asset), expected = capi_test::shading(made);
    for (const Shading* s : {&shading, &expected})
        ASSERT_EQ(penumbra_shading_set_material(s->get(), PENUMBRA_ALL_SLOTS, kLive, nullptr), PENUMBRA_OK);
    Frame frame(info), frame_of_made(info);
    frame.evaluate(character(asset).get(), info);
    frame_of_made.evaluate(character(made).get(), info);
    ASSERT_EQ(frame.shade(shading.get(), 0, info.vertex_count), 0);
    const std::vector<float> before = frame.radiance;
    const std::size_t allocations = allocationCount();
    EXPECT_EQ(penumbra_shading_set_material_parameter(shading.get(), kLive, "exponent", 60, nullptr), PENUMBRA_OK);
    frame.shade(shading.get(), 0, info.vertex_count);
    EXPECT_EQ(allocationCount(), allocations);
    frame_of_made.shade(expected.get(), 0, info.vertex_count);
    EXPECT_EQ(frame.radiance, frame_of_made.radiance);
    EXPECT_NE(frame.radiance, before);
    penumbra_parameter parameter;
    ASSERT_EQ(penumbra_shading_get_material_parameter(shading.get(), kLive, &parameter, nullptr), PENUMBRA_OK);
    EXPECT_STREQ(parameter.name, "exponent");
    EXPECT_EQ(parameter.value, 60);
    EXPECT_EQ(parameter.most, 1000);
}

TEST(CApiParameter, WrongOnesAreNamed) {
    const std::vector<std::byte> bytes = liveAsset("ggx-live");
    const Asset asset = open(bytes);
    const Shading shading = capi_test::shading(asset);
    penumbra_error error;
    const auto set = [&](std::size_t material, const char* name, double value) {
        return penumbra_shading_set_material_parameter(shading.get(), material, name, value, &error);
    };
    for (const double value : {-1.0, 0.0, 1e5, std::nan("")}) {
        EXPECT_EQ(set(kLive, "alpha", value), PENUMBRA_INVALID_ARGUMENT) << value;
        EXPECT_THAT(error.message, HasSubstr("ggx-live alpha must be a number from 0.01 to 1"));
    }
    EXPECT_EQ(set(kLive, "exponent", 1), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no parameter \"exponent\", only \"alpha\""));
    EXPECT_EQ(set(0, "alpha", 0.5), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("material 0 has no parameter that changes"));
    EXPECT_EQ(set(9, "alpha", 0.5), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(set(kLive, nullptr, 0.5), PENUMBRA_INVALID_ARGUMENT);
    penumbra_material material;
    ASSERT_EQ(penumbra_asset_get_material(asset.get(), kLive, &material), PENUMBRA_OK);
    EXPECT_EQ(material.slices, nullptr);
}

// Steps of ggx alpha whose slices are multiples of a Lambertian material's.
std::vector<std::byte> steppedAsset() {
    BrdfFile brdf = synthetic::lambert();
    brdf.name = "stepped";
    brdf.lobes = {lobeOf(parseBrdf("ggx:alpha=0.2"))};
    brdf.steps = BrdfSteps{0, {0.1, 0.2, 0.4}, {}, 0.01};
    for (const double scale : {0.5, 1.0, 2.0})
        for (const double value : brdf.slices) brdf.steps->slices.push_back(scale * value);
    return packAsset(synthetic::tubeModel({}), std::vector<BrdfFile>{synthetic::lambert(), brdf}, lights(3), {}, "{}",
                     1)
        .bytes;
}

TEST(CApiParameter, IsInterpolatedBetweenSteps) {
    const std::vector<std::byte> bytes = steppedAsset();
    const Asset asset = open(bytes);
    const penumbra_asset_info info = infoOf(asset);
    const Shading shading = capi_test::shading(asset);
    ASSERT_EQ(penumbra_shading_set_material(shading.get(), PENUMBRA_ALL_SLOTS, kLive, nullptr), PENUMBRA_OK);
    Frame frame(info);
    frame.evaluate(character(asset).get(), info);
    ASSERT_EQ(frame.shade(shading.get(), 0, info.vertex_count), 0);
    const std::vector<float> before = frame.radiance;
    for (const auto& [alpha, scale] : {std::pair(0.1, 0.5f), {0.4, 2.0f}, {0.15, 0.75f}, {0.3, 1.5f}, {0.2, 1.0f}}) {
        ASSERT_EQ(penumbra_shading_set_material_parameter(shading.get(), kLive, "alpha", alpha, nullptr), PENUMBRA_OK);
        frame.shade(shading.get(), 0, info.vertex_count);
        for (std::size_t i = 0; i < before.size(); ++i)
            ASSERT_NEAR(frame.radiance[i], scale * before[i], 2e-6f * std::abs(before[i])) << alpha;
    }
    penumbra_parameter parameter;
    ASSERT_EQ(penumbra_shading_get_material_parameter(shading.get(), kLive, &parameter, nullptr), PENUMBRA_OK);
    EXPECT_STREQ(parameter.name, "alpha");
    EXPECT_FLOAT_EQ(float(parameter.value), 0.2f);
    EXPECT_EQ(parameter.least, 0.1);
    EXPECT_EQ(parameter.most, 0.4);
    penumbra_error error;
    for (const double value : {-1.0, 0.05, 0.41, 1e5, std::nan("")}) {
        EXPECT_EQ(penumbra_shading_set_material_parameter(shading.get(), kLive, "alpha", value, &error),
                  PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(error.message, HasSubstr("ggx alpha must be a number from 0.1 to 0.4"));
    }
    EXPECT_EQ(penumbra_shading_set_material_parameter(shading.get(), kLive, "f0", 0.5, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no parameter \"f0\", only \"alpha\""));
}

TEST(CApiSides, AreEachOthersOther) {
    const std::vector<std::byte> cloth = packAsset(synthetic::clothModel(), {}, {}, {}, "{}", 1).bytes, tube = packed();
    const Asset sheet = open(cloth), solid = open(tube);
    std::vector<std::uint32_t> other(infoOf(sheet).vertex_count);
    ASSERT_EQ(penumbra_asset_get_other_sides(sheet.get(), other.data(), nullptr), PENUMBRA_OK);
    for (std::uint32_t v = 0; v < other.size(); ++v) {
        EXPECT_NE(other[v], v);
        EXPECT_EQ(other[other[v]], v);
    }
    EXPECT_EQ(penumbra_asset_get_other_sides(solid.get(), other.data(), nullptr), PENUMBRA_UNSUPPORTED);
}

}  // namespace
}  // namespace penumbra::test_material_parameter
