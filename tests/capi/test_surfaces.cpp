// The parts D, A and B of textured assets: an engine shades with three materials and joins them with its own textures.
#include <gtest/gtest.h>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "tests/capi/packed_asset.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/textured_tube.h"

namespace penumbra::test_surfaces {
namespace {

using namespace capi_test;
using synthetic::TexturedSlots;

std::vector<std::byte> textured() {
    return synthetic::texturedTube(TexturedSlots::kClothAndCard, synthetic::light(4, 0.3));
}

TEST(CApiSurfaces, NumbersAreThoseOfTheAsset) {
    const std::vector<std::byte> bytes = textured();
    const AssetView view = openAsset(bytes);
    const Asset asset = open(bytes);
    for (std::size_t s = 0; s < 2; ++s) {
        const SlotSurface& look = view.surface->slots[s];
        penumbra_slot_surface slot;
        ASSERT_EQ(penumbra_asset_slot_surface(asset.get(), s, &slot), 1);
        for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(slot.base[c], look.base[c]);
            EXPECT_EQ(slot.emissive[c], look.emissive[c]);
            EXPECT_EQ(slot.f0[c], look.f0[c]);
        }
        EXPECT_EQ(slot.f90, look.f90);
        EXPECT_EQ(slot.metallic, look.metallic);
        EXPECT_EQ(slot.roughness, look.roughness);
        EXPECT_EQ(slot.normal_scale, look.normal_scale);
        EXPECT_EQ(slot.occlusion_strength, look.occlusion_strength);
        EXPECT_EQ(slot.alpha, look.alpha);
        EXPECT_EQ(slot.alpha_cutoff, look.alpha_cutoff);
        EXPECT_EQ(slot.diffuse, look.materials.diffuse);
        ASSERT_EQ(slot.steps, look.materials.steps);
        for (std::size_t step = 0; step < slot.steps; ++step) {
            EXPECT_EQ(slot.step_roughness[step], look.materials.roughness[step]);
            EXPECT_EQ(slot.step_f0[step], look.materials.f0[step]);
            EXPECT_EQ(slot.step_f90[step], look.materials.f90[step]);
        }
    }
    penumbra_slot_surface slot;
    EXPECT_EQ(penumbra_asset_slot_surface(asset.get(), 2, &slot), 0);
    EXPECT_EQ(penumbra_asset_slot_surface(asset.get(), 0, nullptr), 0);
    EXPECT_EQ(penumbra_asset_slot_surface(nullptr, 0, &slot), 0);
    const std::vector<std::byte> plain = packed();
    EXPECT_EQ(penumbra_asset_slot_surface(open(plain).get(), 0, &slot), 0) << "an asset without textures has none";
}

// The terms that an engine computes in a frame: each part of both slots into an array of its own.
struct Terms {
    std::vector<float> d, a[2], b[2];

    int shade(Frame& frame, const Shading& shading, const penumbra_slot_surface (&slots)[2]) {
        const auto part = [&](std::vector<float>& out, std::size_t first, std::size_t second) {
            int status = penumbra_shading_set_material(shading.get(), 0, first, nullptr);
            status |= penumbra_shading_set_material(shading.get(), 1, second, nullptr);
            status |= frame.shade(shading.get(), 0, frame.ambient.size());
            out = frame.radiance;
            return status;
        };
        int status = part(d, slots[0].diffuse, slots[1].diffuse);
        for (std::size_t step = 0; step < 2; ++step) {
            const std::size_t of_second = std::min(step, slots[1].steps - 1);
            status |= part(a[step], slots[0].step_f0[step], slots[1].step_f0[of_second]);
            status |= part(b[step], slots[0].step_f90[step], slots[1].step_f90[of_second]);
        }
        return status;
    }
};

// The terms are those that the player's CPU path draws from, and no frame allocates. Measured: 6e-8.
TEST(CApiSurfaces, TermsAreThoseOfThePlayer) {
    const std::vector<std::byte> bytes = textured();
    const AssetView view = openAsset(bytes);
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    const Shading shading = capi_test::shading(asset);
    const penumbra_asset_info info = infoOf(asset);
    penumbra_slot_surface slots[2];
    for (std::size_t s = 0; s < 2; ++s) ASSERT_EQ(penumbra_asset_slot_surface(asset.get(), s, &slots[s]), 1);
    Frame frame(info);
    Terms terms;
    const auto run = [&](std::size_t f) {
        int status = penumbra_character_set_frame(character.get(), f % info.frame_count, nullptr);
        status |= frame.evaluate(character.get(), info);
        return status | terms.shade(frame, shading, slots);
    };
    EXPECT_EQ(run(0), PENUMBRA_OK);
    const std::size_t before = allocationCount();
    for (std::size_t f = 0; f < 100; ++f) EXPECT_EQ(run(f), PENUMBRA_OK);
    EXPECT_EQ(allocationCount(), before);
    EXPECT_EQ(run(1), PENUMBRA_OK);

    ShadingSet set(view);
    set.showSurface();
    Evaluator evaluator(view);
    evaluator.setFrame(1);
    const PosedArrays posed(evaluator);
    const std::size_t count = info.vertex_count, slopes = 3;
    std::vector<Vec3> expected(set.terms() * count);
    ASSERT_EQ(set.terms(), 1 + slopes + 4);
    set.shadeTerms(posed.all(), {frame.eye[0], frame.eye[1], frame.eye[2]}, expected);
    const auto expectTerm = [&](const std::vector<float>& got, std::size_t term) {
        std::size_t lit = 0;
        for (std::size_t v = 0; v < count; ++v) {
            const bool shown = term < 1 + slopes + 2 || info.slot_of_vertex[v] == 0;  // the second slot has one step
            if (!shown) continue;
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(got[3 * v + c], expected[term * count + v][int(c)], 1e-6) << "term " << term << " of " << v;
            lit += got[3 * v] > 0;
        }
        EXPECT_GT(lit, count / 4);
    };
    expectTerm(terms.d, 0);
    for (std::size_t step = 0; step < 2; ++step) {
        expectTerm(terms.a[step], 1 + slopes + 2 * step);
        expectTerm(terms.b[step], 2 + slopes + 2 * step);
    }
}

}  // namespace
}  // namespace penumbra::test_surfaces
