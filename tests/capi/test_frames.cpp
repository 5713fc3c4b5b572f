// Tests what an engine does all day: frames without allocation, from several threads, of many characters.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/capi/packed_asset.h"
#include "tests/runtime/count_allocations.h"

namespace penumbra::test_frames {
namespace {

using namespace capi_test;

TEST(CApiFrames, NothingIsAllocatedPerFrame) {
    for (const FeatureKind features : synthetic::kSkinnedFeatures) {
        Recipe recipe;
        recipe.tube.features = features;
        const std::vector<std::byte> bytes = packed(recipe);
        const std::size_t before = allocationCount();
        const Asset asset = open(bytes);
        EXPECT_GT(allocationCount(), before) << "the library's allocations are not counted";
        const penumbra_asset_info info = infoOf(asset);
        const Character character = capi_test::character(asset);
        const Shading shading = capi_test::shading(asset, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4});
        Frame frame(info);
        penumbra_light light;
        penumbra_asset_get_light(asset.get(), 1, &light);
        penumbra_frame stored;
        penumbra_asset_get_frame(asset.get(), 1, &stored);
        const float turn[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
        const std::size_t after = allocationCount();
        int status = 0;
        for (std::size_t f = 0; f < 1000; ++f) {
            penumbra_error error;
            status |= penumbra_character_set_frame(character.get(), f % info.frame_count, &error);
            status |= penumbra_character_set_pose(character.get(), PENUMBRA_ROWS_3X4, stored.matrices, info.joint_count,
                                                  stored.rotations, info.rotation_count, &error);
            status |= frame.evaluate(character.get(), info, 2);
            status |= penumbra_shading_set_material(shading.get(), f % 2, f % 2, &error);
            status |= penumbra_shading_set_light(shading.get(), f % 2, &error);
            if (f % 3 == 0) status |= penumbra_shading_set_sh_light(shading.get(), light.order, light.sh, 0, &error);
            status |= penumbra_shading_set_light_rotation(shading.get(), turn, &error);
            status |= frame.shade(shading.get(), 0, info.vertex_count);
        }
        EXPECT_EQ(status, PENUMBRA_OK);
        EXPECT_EQ(allocationCount() - after, 0u);
    }
}

// The tube's clips turn joints only, so its frames follow from their rotations.
TEST(CApiFrames, RotationsAloneMakeTheSamePose) {
    const Model model = synthetic::tubeModel();
    for (const FeatureKind features : synthetic::kSkinnedFeatures) {
        Recipe recipe;
        recipe.tube.features = features;
        const std::vector<std::byte> bytes = packed(recipe);
        const Asset asset = open(bytes);
        const penumbra_asset_info info = infoOf(asset);
        const Character by_frame = character(asset), by_rotations = character(asset);
        const std::size_t size = 3 * info.joint_count, before = allocationCount();
        std::size_t allocated = 0;
        for (std::size_t f = 0; f < info.frame_count; ++f) {
            penumbra_character_set_frame(by_frame.get(), f, nullptr);
            const std::size_t at = allocationCount();
            EXPECT_EQ(
                penumbra_character_set_rotations(by_rotations.get(), nullptr, &model.pose[f * size], size, nullptr),
                PENUMBRA_OK);
            allocated += allocationCount() - at;
            Frame expected(info), frame(info);
            expected.evaluate(by_frame.get(), info);
            frame.evaluate(by_rotations.get(), info);
            for (std::size_t i = 0; i < frame.positions.size(); ++i)
                ASSERT_NEAR(frame.positions[i], expected.positions[i], 1e-6f) << "frame " << f;
            for (std::size_t i = 0; i < frame.coefficients.size(); ++i)
                ASSERT_NEAR(frame.coefficients[i], expected.coefficients[i], 2e-5f) << "frame " << f;
        }
        EXPECT_EQ(allocated, 0u);
        EXPECT_GT(allocationCount(), before) << "allocations are not counted";
    }
}

// `root` moves the character as a whole. Shadows stay, and positions turn with it.
TEST(CApiFrames, RootMovesTheWholeCharacter) {
    const std::vector<std::byte> bytes = packed();
    const Asset asset = open(bytes);
    const penumbra_asset_info info = infoOf(asset);
    const Character still = character(asset), moved = character(asset);
    const std::vector<float> rotations(3 * info.joint_count, 0.2f);
    const float root[12] = {0, 0, 1, 5, 0, 1, 0, -2, -1, 0, 0, 1};  // a quarter turn about y
    penumbra_character_set_rotations(still.get(), nullptr, rotations.data(), rotations.size(), nullptr);
    penumbra_character_set_rotations(moved.get(), root, rotations.data(), rotations.size(), nullptr);
    Frame a(info), b(info);
    a.evaluate(still.get(), info);
    b.evaluate(moved.get(), info);
    for (std::size_t v = 0; v < info.vertex_count; ++v) {
        EXPECT_NEAR(b.positions[3 * v], a.positions[3 * v + 2] + 5, 1e-5f);
        EXPECT_NEAR(b.positions[3 * v + 1], a.positions[3 * v + 1] - 2, 1e-5f);
        EXPECT_NEAR(b.positions[3 * v + 2], -a.positions[3 * v] + 1, 1e-5f);
        EXPECT_NEAR(b.ambient[v], a.ambient[v], 1e-4f);
    }
}

// Each of a hundred characters of one asset costs little beside the asset's own decoding.
TEST(CApiFrames, CharactersShareTheDecodedModel) {
    const std::vector<std::byte> bytes = packed({.tube = {.joints = 12, .clusters = 8, .inputs = 16}});
    const Asset asset = open(bytes);
    const std::size_t before = allocationCount();
    const Character first = character(asset);
    const std::size_t decoded = allocationCount() - before;
    const Character second = character(asset);
    const std::size_t shared = allocationCount() - before - decoded;
    EXPECT_LT(10 * shared, decoded) << decoded << " allocations for the first, " << shared << " for the second";
}

// A frame that is split over threads equals the frame of one thread. Characters of one asset move at the same time.
TEST(CApiFrames, ThreadsSplitFramesAndShareAssets) {
    Recipe recipe{.tube = {.rings = 40, .segments = 30, .clusters = 16}};
    const std::vector<std::byte> bytes = packed(recipe);
    const Asset asset = open(bytes);
    const penumbra_asset_info info = infoOf(asset);
    const Shading shading = capi_test::shading(asset);
    const auto whole = [&](std::size_t f) {
        const Character character = capi_test::character(asset);
        Frame frame(info);
        penumbra_character_set_frame(character.get(), f, nullptr);
        frame.evaluate(character.get(), info);
        frame.shade(shading.get(), 0, info.vertex_count);
        return frame.radiance;
    };
    std::vector<std::vector<float>> expected;
    for (std::size_t f = 0; f < info.frame_count; ++f) expected.push_back(whole(f));

    std::atomic<int> wrong = 0;
    std::vector<std::thread> characters;
    for (std::size_t t = 0; t < 8; ++t)
        characters.emplace_back([&, t] {
            for (std::size_t f = 0; f < 50; ++f)
                wrong += whole((f + t) % info.frame_count) != expected[(f + t) % info.frame_count];
        });
    for (std::thread& thread : characters) thread.join();
    EXPECT_EQ(wrong, 0);

    const Character character = capi_test::character(asset);
    Frame frame(info);
    const penumbra_vertices vertices = frame.vertices();
    penumbra_character_set_frame(character.get(), 1, nullptr);
    const auto inParts = [](std::size_t count, auto body) {
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < 4; ++t)
            threads.emplace_back(body, count * t / 4, count * (t + 1) / 4 - count * t / 4);
        for (std::thread& thread : threads) thread.join();
    };
    inParts(info.cluster_count, [&](std::size_t first, std::size_t count) {
        penumbra_character_evaluate(character.get(), first, count, &vertices, nullptr);
    });
    inParts(info.vertex_count, [&](std::size_t first, std::size_t count) {
        const penumbra_vertices some = frame.vertices(first, count);
        penumbra_character_skin(character.get(), &some, nullptr);
    });
    inParts(info.vertex_count, [&](std::size_t first, std::size_t count) { frame.shade(shading.get(), first, count); });
    EXPECT_EQ(frame.radiance, expected[1]);
}

}  // namespace
}  // namespace penumbra::test_frames
