// Light that bounces in an asset: what it holds, what it costs, how it is shaded, and what the reader refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "sh/sh_rotation.h"
#include "tests/pack/changed_asset.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_indirect_asset {
namespace {

using synthetic::litTube;

constexpr PackOptions kExact{.precision = AssetPrecision::kF32};

Packed packedTube(const PackOptions& options = kExact, const Model& model = litTube()) {
    return packAsset(model, std::vector{synthetic::lambert({0.5, 0.5, 0.5})}, std::vector{synthetic::light(4, 0.3)},
                     options, "{}", 1);
}

TEST(IndirectAsset, HoldsWhatTheModelHas) {
    const Model model = litTube();
    const Packed packed = packedTube(kExact, model);
    const AssetView asset = openAsset(packed.bytes);
    ASSERT_TRUE(asset.model.indirect);
    EXPECT_EQ(asset.model.indirect->bounces, 3);
    EXPECT_EQ(asset.model.indirect->axes, model.indirect->axes);
    EXPECT_FLOAT_EQ(asset.model.indirect->holdout_share, 0.03f);
    Evaluator evaluator(asset);
    evaluator.setFrame(1);
    std::vector<float> found(evaluator.vertexCount() * kIndirectStride, -1.0f);
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
        evaluator.evaluateIndirect(c, found);
        const ClusterModel& cluster = model.indirect->clusters[c];
        const std::span<const float> y = evaluator.indirectScores(c);
        ASSERT_EQ(y.size(), cluster.components());
        const std::size_t first = asset.model.clusters[c].first_vertex, rows = cluster.mean.size();
        for (std::size_t v = 0; v < cluster.vertices.size(); ++v) {
            const float* row = found.data() + (first + v) * kIndirectStride;
            for (std::size_t i = 0; i < kIndirectSize; ++i) {
                double expected = cluster.mean[v * kIndirectSize + i];
                for (std::size_t k = 0; k < y.size(); ++k)
                    expected += double(y[k]) * cluster.basis[k * rows + v * kIndirectSize + i];
                EXPECT_NEAR(row[i], expected, 1e-5);
            }
            EXPECT_EQ(row[kIndirectSize], 0);
        }
    }
}

TEST(IndirectAsset, AssetsWithoutItKeepTheirBytes) {
    Model model = litTube();
    model.indirect.reset();
    EXPECT_EQ(packedTube(kExact, model).bytes, packedTube(kExact, synthetic::tubeModel()).bytes);
}

TEST(IndirectAsset, StaysWithinItsBytesAndSaysWhatThatCosts) {
    Model model = litTube({.rings = 40, .segments = 20, .components = 6, .frames = 12, .kind = ModelKind::kAdditive});
    synthetic::turnJointsApart(model);  // scores that change more than the mean is rounded
    const double vertices = double(model.mesh.vertexCount());
    double before = 0;
    for (const double bound : {24.0, 48.0, 200.0}) {
        const Packed packed = packedTube({.indirect_bytes_per_vertex = bound}, model);
        const AssetView asset = openAsset(packed.bytes);
        for (const SizeOf& size : sectionSizes(asset, packed.bytes.size())) {
            if (size.section != kBouncedSection) continue;
            EXPECT_LE(double(size.bytes), bound * vertices);
        }
        EXPECT_GE(packed.indirect_components, std::size_t(before));
        before = double(packed.indirect_components);
        EXPECT_NEAR(asset.model.indirect->packing_error, packed.indirect_error, 1e-6);
        // With all six components 0.17 measured, by the bytes of means and units.
        EXPECT_LT(packed.indirect_error, bound == 200 ? 0.2 : 1.0);
    }
    EXPECT_THROW(packedTube({.indirect_bytes_per_vertex = 5}, model), UsageError);
}

TEST(IndirectAsset, RefusesOtherClustersAndAxes) {
    Model model = litTube();
    model.indirect->clusters.pop_back();
    EXPECT_THROW(packedTube(kExact, model), InvalidInput);
    model = litTube();
    model.indirect->axes.m[0] = 2;
    EXPECT_THROW(openAsset(packedTube(kExact, model).bytes), InvalidInput);
    model = litTube();
    model.indirect->bounces = 0;
    EXPECT_THROW(openAsset(packedTube(kExact, model).bytes), InvalidInput);
}

TEST(IndirectAsset, RejectsEveryTruncation) {
    const std::vector<std::byte> whole =
        packedTube({.precision = AssetPrecision::kI8}, litTube({.rings = 3, .segments = 3})).bytes;
    expectTruncationsRefused(whole);
}

// E_ind of a vertex by the definition: the light turned into the local frame, times the numbers.
Vec3 indirectLight(const ColorAxes& axes, std::span<const float> coefficients, const Mat3& to_local,
                   std::span<const float> light) {
    const ShRotation turn = makeShRotation(kIndirectOrder, to_local);
    std::array<float, kIndirectCoefficients> model, local;
    Vec3 sum;
    for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < model.size(); ++i) model[i] = light[3 * i + std::size_t(c)];
        apply(turn, std::span<const float>(model), std::span<float>(local));
        for (std::size_t i = 0; i < model.size(); ++i)
            sum[c] += local[i] * indirectCoefficient(axes, coefficients, i)[c];
    }
    return sum;
}

// A Lambertian surface sends back albedo / pi E_ind, which the rule of glossy materials gives too.
TEST(IndirectAsset, LambertSendsBackTheLightThatBounces) {
    const Packed packed = packedTube();
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(2);
    const PosedArrays shaded(evaluator);
    ShadingSet set(asset);
    for (const ShadePath& path : shadePaths()) {
        set.usePath(path);
        set.setBounces(Bounces::kBoth);
        const std::vector<Vec3> both = shaded.shade(set, {0, 1, 4});
        set.setBounces(Bounces::kDirect);
        const std::vector<Vec3> direct = shaded.shade(set, {0, 1, 4});
        set.setBounces(Bounces::kIndirect);
        const std::vector<Vec3> indirect = shaded.shade(set, {0, 1, 4});
        for (std::size_t v = 0; v < both.size(); ++v) {
            const Vec3 light = indirectLight(asset.model.indirect->axes,
                                             std::span(shaded.indirect).subspan(v * kIndirectStride, kIndirectStride),
                                             toLocalFrame(shaded.normals[v], shaded.tangents[v]), asset.lights[0].sh);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(both[v][c], direct[v][c] + indirect[v][c], 1e-5) << path.name;
                EXPECT_NEAR(indirect[v][c], std::max(0.0f, 0.5f / std::numbers::pi_v<float> * light[c]), 2e-5)
                    << path.name;
            }
        }
    }
}

TEST(IndirectAsset, TurnedLightBouncesTurned) {
    const Packed packed = packedTube();
    const AssetView asset = openAsset(packed.bytes);
    ShadingSet set(asset);
    const Mat3 turn{{0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0, 0.48f, 0.64f, 0.6f}};
    set.setLightRotation(turn);
    const ShRotation rotation = makeShRotation(kIndirectOrder, turn);
    std::array<float, kIndirectCoefficients> from, to;
    for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < from.size(); ++i) from[i] = asset.lights[0].sh[3 * i + std::size_t(c)];
        apply(rotation, std::span<const float>(from), std::span<float>(to));
        for (std::size_t i = 0; i < to.size(); ++i) EXPECT_NEAR(set.lightTables().whole()[i][c], to[i], 1e-5);
    }
}

TEST(IndirectAsset, AmbientWithBouncesIsWhatUniformLightGives) {
    const Packed packed = packedTube();
    const AssetView asset = openAsset(packed.bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(0);
    const PosedArrays shaded(evaluator);
    std::vector<float> e(shaded.positions.size());
    addBouncedAmbient(asset.model.indirect->axes, shaded.indirect, e);
    for (std::size_t v = 0; v < e.size(); ++v) {
        const Vec3 mean = indirectCoefficient(
            asset.model.indirect->axes, std::span(shaded.indirect).subspan(v * kIndirectStride, kIndirectStride), 0);
        const double expected =
            std::sqrt(4 * std::numbers::pi) / std::numbers::pi * (0.2126 * mean.x + 0.7152 * mean.y + 0.0722 * mean.z);
        EXPECT_NEAR(e[v], std::clamp(expected, 0.0, 1.0), 1e-6);
    }
}

}  // namespace
}  // namespace penumbra::test_indirect_asset
