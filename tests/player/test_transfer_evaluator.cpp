// The evaluator of transfer as the player uses it: frames, errors against the truth, and no allocation.
#include <gtest/gtest.h>

#include "pack/pack_transfer.h"
#include "player/papers/transfer/transfer_model.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_transfer.h"

namespace penumbra::test_transfer_evaluator {
namespace {

std::vector<std::byte> packedTube(TransferModelKind kind) {
    return packTransfer(synthetic::tubeTransfer(kind, 6, {.rings = 30, .segments = 20}),
                        std::vector{diffuseMaterial({1, 1, 1})}, std::vector{synthetic::light(5, 0.3)}, {}, "{}");
}

TEST(TransferEvaluator, AFrameAllocatesNothing) {
    for (const TransferModelKind kind : kTransferModelKinds) {
        const std::vector<std::byte> bytes = packedTube(kind);
        const AssetView asset = openAsset(bytes);
        ShadingSet set(asset);
        Evaluator evaluator(asset);
        std::vector<Vec3> radiance(evaluator.vertexCount());
        std::vector<float> coefficients(radiance.size() * std::size_t(asset.model.stride));
        evaluator.transfer()->setLight(set.lightTables().sh());
        const std::size_t before = allocationCount();
        evaluator.setFrame(1);
        set.setLightRotation({{0, 0, 1, 0, 1, 0, -1, 0, 0}});
        evaluator.transfer()->setLight(set.lightTables().sh());
        evaluator.transfer()->irradiance(0, radiance.size(), radiance);
        evaluator.evaluateCluster(0, coefficients);
        EXPECT_EQ(allocationCount() - before, 0u);
    }
}

// A light that is set again is known, and one that differs in a number is not.
TEST(TransferEvaluator, FollowsTheLight) {
    const std::vector<std::byte> bytes = packedTube(TransferModelKind::kPca);
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(0);
    std::vector<Vec3> light(25, Vec3{0.1f, 0.2f, 0.3f}), dark(1), bright(1), again(1);
    evaluator.transfer()->setLight(light);
    evaluator.transfer()->irradiance(7, 8, dark);
    light[3] = {1, 1, 1};
    evaluator.transfer()->setLight(light);
    evaluator.transfer()->irradiance(7, 8, bright);
    EXPECT_NE(dark, bright);
    light[3] = {0.1f, 0.2f, 0.3f};
    evaluator.transfer()->setLight(light);
    evaluator.transfer()->irradiance(7, 8, again);
    EXPECT_EQ(dark, again);
}

}  // namespace
}  // namespace penumbra::test_transfer_evaluator
