// Assets of transfer through the C interface: the ordinary calls work, and what cannot be says why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pack/pack_transfer.h"
#include "tests/capi/use_c_api.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_transfer.h"

namespace penumbra::test_transfer {
namespace {

using namespace capi_test;
using testing::HasSubstr;

std::vector<std::byte> packedTransfer(TransferModelKind kind) {
    return packTransfer(synthetic::tubeTransfer(kind, 4), std::vector{diffuseMaterial({0.5f, 0.25f, 1})},
                        std::vector{synthetic::light(3, 0.3)}, {}, "{}");
}

TEST(CApiTransfer, LoadsAndShadesByTheOrdinaryCalls) {
    for (const TransferModelKind kind : kTransferModelKinds) {
        const std::vector<std::byte> bytes = packedTransfer(kind);
        const Asset asset = open(bytes);
        const penumbra_asset_info info = infoOf(asset);
        EXPECT_EQ(info.has_model, 1);
        EXPECT_STREQ(info.convention, "T4");
        EXPECT_EQ(info.coefficient_count, 16u);
        EXPECT_EQ(info.rotation_count, 9u);
        EXPECT_EQ(info.rest_tangents, nullptr);
        const Character character = capi_test::character(asset);
        const Shading shading = capi_test::shading(asset);
        ASSERT_TRUE(character && shading);
        ASSERT_EQ(penumbra_character_set_frame(character.get(), 1, nullptr), PENUMBRA_OK);
        Frame frame(info);
        ASSERT_EQ(frame.evaluate(character.get(), info), PENUMBRA_OK);
        ASSERT_EQ(frame.shade(shading.get(), 0, info.vertex_count), PENUMBRA_OK);
        const AssetView view = openAsset(bytes);
        const std::span<const float> light = view.lights[0].sh;
        for (std::size_t v = 0; v < info.vertex_count; ++v) {
            const float* t = frame.coefficients.data() + 16 * v;
            EXPECT_NEAR(frame.ambient[v], 2 / std::sqrt(std::numbers::pi) * double(t[0]), 1e-6);
            for (std::size_t channel = 0; channel < 3; ++channel) {
                double sum = 0;
                for (std::size_t c = 0; c < 9; ++c) sum += double(light[3 * c + channel]) * t[c];
                const double albedo = channel == 0 ? 0.5 : channel == 1 ? 0.25 : 1;
                EXPECT_NEAR(frame.radiance[3 * v + channel], albedo / std::numbers::pi * sum, 2e-6);
            }
        }
        // Its coefficients are transfer already.
        const penumbra_vertices vertices = frame.vertices();
        std::vector<float> transfer(25 * info.vertex_count);
        EXPECT_EQ(penumbra_character_transfer(character.get(), 5, &vertices, transfer.data(), nullptr), PENUMBRA_OK);
        for (std::size_t v = 0; v < info.vertex_count; ++v)
            for (std::size_t i = 0; i < 25; ++i)
                EXPECT_EQ(transfer[25 * v + i], i < 16 ? frame.coefficients[16 * v + i] : 0);
        const std::size_t before = allocationCount();
        penumbra_character_set_frame(character.get(), 2, nullptr);
        frame.evaluate(character.get(), info);
        frame.shade(shading.get(), 0, info.vertex_count);
        EXPECT_EQ(allocationCount() - before, 0u);
    }
}

TEST(CApiTransfer, WhatCannotBeIsRefusedWithAReason) {
    const std::vector<std::byte> bytes = packedTransfer(TransferModelKind::kPca);
    const Asset asset = open(bytes);
    const Shading shading = capi_test::shading(asset);
    penumbra_error error;
    std::size_t length = 0;
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), nullptr, 0, &length, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("no shader for transfer"));
    float texel[4];
    EXPECT_EQ(penumbra_shading_get_gpu_materials(shading.get(), texel, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_EQ(penumbra_shading_get_gpu_light(shading.get(), texel, &error), PENUMBRA_UNSUPPORTED);
    for (const penumbra_shading_options& options : {penumbra_shading_options{PENUMBRA_SLICES, PENUMBRA_FIXED_LOBES, 0},
                                                    {PENUMBRA_OPERATORS, PENUMBRA_ROTATION, 0}}) {
        penumbra_shading* none = nullptr;
        EXPECT_EQ(penumbra_shading_create(asset.get(), nullptr, 0, &options, &none, &error), PENUMBRA_UNSUPPORTED);
        EXPECT_THAT(error.message, HasSubstr("transfer is diffuse"));
    }
    const std::vector<std::byte> spheres =
        packAsset(synthetic::tubeModel({}), {}, {}, {.blockers = {{{{0, 1, 0}, 0.5f}}, {1}}}, "{}", 1).bytes;
    const Asset caster = open(spheres);
    const penumbra_asset* casters[] = {caster.get()};
    penumbra_scene* made = nullptr;
    ASSERT_EQ(penumbra_scene_create(casters, 1, &made, &error), PENUMBRA_OK);
    const Scene scene(made);
    const Character character = capi_test::character(asset);
    Frame frame(infoOf(asset));
    EXPECT_EQ(frame.cast(scene.get(), PENUMBRA_NONE, character.get(), nullptr, &error), PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("nothing casts on transfer"));
    const penumbra_asset* transfer[] = {asset.get()};
    EXPECT_EQ(penumbra_scene_create(transfer, 1, &made, &error), PENUMBRA_UNSUPPORTED);
}

TEST(CApiTransfer, MutationsNeverHarm) {
    std::mt19937 random(29);
    const std::vector<std::byte> whole = packedTransfer(TransferModelKind::kPca);
    for (int trial = 0; trial < 1500; ++trial) {
        std::vector<std::byte> bytes = whole;
        for (int i = 0; i < 2; ++i) bytes[random() % bytes.size()] = std::byte(random());
        sealAsset(bytes);
        penumbra_error error;
        const penumbra_status status = useBytes(bytes.data(), bytes.size(), &error);
        ASSERT_TRUE(status == PENUMBRA_OK || status == PENUMBRA_INVALID_ASSET) << error.message;
    }
}

}  // namespace
}  // namespace penumbra::test_transfer
