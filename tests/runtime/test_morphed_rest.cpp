// Tests morph targets at run time: the evaluator deforms as the bake does, and damaged targets are refused.
#include <gtest/gtest.h>

#include <limits>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_morphs.h"

namespace penumbra::test_morphed_rest {
namespace {

std::vector<std::byte> packedMorphs(const Model& model) {
    return packAsset(model, {}, {}, {.precision = AssetPrecision::kF32, .max_error = {}}, "{}", 1).bytes;
}

// The weights pass through bones, which rounds them: 3e-7 was measured.
TEST(MorphedRest, DeformsAsTheBakeDoes) {
    const Model model = synthetic::morphTube();
    const std::vector<std::byte> bytes = packedMorphs(model);
    const AssetView asset = openAsset(bytes);
    ASSERT_EQ(asset.mesh.morphs.count(), 2u);
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<Vec3> positions(count), normals(count), tangents(count);
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        evaluator.setFrame(f);
        EXPECT_NEAR(evaluator.rest().weights()[1], synthetic::morphWeightsOf(f)[1], 1e-6);
        evaluator.skin(0, count, positions, normals, tangents);
        const RestShape expected = synthetic::morphedFrame(model, f);
        for (std::size_t v = 0; v < count; ++v) {
            EXPECT_LT(length(positions[v] - expected.positions[asset.mesh.shading_point[v]]), 2e-6f);
            EXPECT_LT(length(normals[v] - expected.normals[asset.mesh.shading_point[v]]), 2e-6f);
        }
    }
}

TEST(MorphedRest, SetsAPoseWithoutAllocating) {
    const std::vector<std::byte> bytes = packedMorphs(synthetic::morphTube());
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(0);
    const std::size_t before = allocationCount();
    evaluator.setFrame(1);
    EXPECT_EQ(allocationCount(), before);
}

TEST(MorphedRest, DamagedTargetsAreRefused) {
    const auto refuses = [](auto damage) {
        std::vector<std::byte> bytes = packedMorphs(synthetic::morphTube());
        damage(*fbs::GetMutableAsset(bytes.data())->mutable_mesh()->mutable_morphs());
        ASSERT_TRUE(sealAsset(bytes));
        EXPECT_THROW(openAsset(bytes), InvalidInput);
    };
    refuses([](fbs::Morphs& m) { m.mutable_first()->Mutate(1, m.vertices()->size() + 1); });
    refuses([](fbs::Morphs& m) { m.mutable_first()->Mutate(0, 1); });
    refuses([](fbs::Morphs& m) { m.mutable_first()->Mutate(2, 3); });
    refuses([](fbs::Morphs& m) { m.mutable_vertices()->Mutate(1, m.vertices()->Get(0)); });
    refuses([](fbs::Morphs& m) { m.mutable_vertices()->Mutate(0, 1u << 20); });
    refuses([](fbs::Morphs& m) { m.mutable_positions()->Mutate(3, std::numeric_limits<float>::quiet_NaN()); });
    Model model = synthetic::morphTube();
    model.input_joints[1].columns = 3;
    EXPECT_THROW(openAsset(packedMorphs(model)), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_morphed_rest
