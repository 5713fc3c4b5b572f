// Assets of transfer: what they hold, that every path of the run time evaluates them as their formula says, and what
// their reader refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "pack/pack_transfer.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "tests/pack/changed_asset.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_transfer.h"
#include "tests/use_asset.h"

namespace penumbra::test_transfer_asset {
namespace {

using synthetic::tubeTransfer;
using testing::HasSubstr;

constexpr Vec3 kAlbedo{0.5f, 0.25f, 0.125f};

std::vector<std::byte> packed(const TransferModel& model, AssetPrecision precision = AssetPrecision::kF32,
                              int light_order = 4) {
    return packTransfer(model, std::vector{diffuseMaterial(kAlbedo)}, std::vector{synthetic::light(light_order, 0.3)},
                        {.precision = precision}, "{}");
}

// The formula of formats/asset.fbs in double and plain loops, [V, n].
std::vector<double> reference(const TransferModel& model, std::span<const float> pose) {
    const std::size_t n = model.coefficients(), k = model.inputs(), m = model.outputs(),
                      vertices = model.mesh.vertexCount();
    std::vector<double> inputs(k + 1), out(vertices * n);
    for (std::size_t i = 0; i < k; ++i)
        for (std::size_t a = 0; a < model.angles.size(); ++a)
            inputs[i] += double(pose[model.angles[a]]) *
                         (model.pose_basis.empty() ? double(a == i) : double(model.pose_basis[a * k + i]));
    inputs[k] = 1;
    for (std::size_t c = 0; c < n; ++c)
        for (std::size_t j = 0; j < m; ++j) {
            double score = 0;
            for (std::size_t i = 0; i <= k; ++i) score += inputs[i] * model.weights[(c * (k + 1) + i) * m + j];
            if (model.basis.empty())
                out[j * n + c] = score;
            else
                for (std::size_t v = 0; v < vertices; ++v) out[v * n + c] += score * model.basis[j * vertices + v];
        }
    for (std::size_t v = 0; v < vertices && !model.mean.empty(); ++v)
        for (std::size_t c = 0; c < n; ++c) out[v * n + c] += model.mean[v];
    return out;
}

// 3 clusters of 512 and 97 vertices: no tile of the kernels is left out.
const synthetic::TubeOptions kLarge{.rings = 27, .segments = 23};

TEST(TransferAsset, HoldsTheModel) {
    for (const TransferModelKind kind : kTransferModelKinds) {
        const TransferModel model = tubeTransfer(kind, 3);
        const std::vector<std::byte> bytes = packed(model);
        const AssetView asset = openAsset(bytes);
        ASSERT_TRUE(asset.transfer.has_value());
        EXPECT_FALSE(asset.has_model);
        EXPECT_TRUE(asset.hasCharacter());
        EXPECT_EQ(asset.transfer->inputs(), model.inputs());
        EXPECT_EQ(asset.transfer->outputs(), model.outputs());
        EXPECT_EQ(asset.model.stride, 12);
        // What the paper counts, the mean and the bias. The angles and their numbers are ours.
        std::size_t listed = 0;
        for (const SizeOf& size : sectionSizes(asset, bytes.size()))
            if (size.section == "transfer") listed = size.bytes;
        EXPECT_EQ(listed, modelBytes(model) + 4 * model.angles.size());
        useAsset(asset);
    }
}

TEST(TransferAsset, EveryPathEvaluatesTheFormula) {
    for (const TransferModelKind kind : kTransferModelKinds)
        for (const int order : {1, 3, 6, 8}) {
            const TransferModel model = tubeTransfer(kind, order, kLarge);
            const std::vector<std::byte> bytes = packed(model);
            const AssetView asset = openAsset(bytes);
            const std::size_t n = model.coefficients(), stride = std::size_t(asset.model.stride);
            const std::vector<double> expected = reference(model, asset.animation.poseOf(1));
            for (const TransferPath& path : transferPaths()) {
                Evaluator evaluator(asset);
                evaluator.transfer()->usePath(path);
                evaluator.setFrame(1);
                const std::vector<float> coefficients = coefficientsOf(evaluator);
                for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
                    for (std::size_t c = 0; c < stride; ++c)
                        ASSERT_NEAR(coefficients[v * stride + c], c < n ? expected[v * n + c] : 0, 3e-6)
                            << path.name << " order " << order << " vertex " << v << " number " << c;
            }
        }
}

// Light first is the same sum in another order. A light may have fewer bands than the transfer, and more.
TEST(TransferAsset, LightFirstIsLightTimesTransfer) {
    for (const TransferModelKind kind : kTransferModelKinds)
        for (const int light_order : {2, 6, 8}) {
            const TransferModel model = tubeTransfer(kind, 6, kLarge);
            const std::vector<std::byte> bytes = packed(model, AssetPrecision::kF32, light_order);
            const AssetView asset = openAsset(bytes);
            const std::vector<double> transfer = reference(model, asset.animation.poseOf(1));
            const ShadingSet set(asset);
            const std::vector<Vec3>& light = set.lightTables().sh();
            const std::size_t n = std::min<std::size_t>(36, light.size()), vertices = model.mesh.vertexCount();
            for (const TransferPath& path : transferPaths()) {
                Evaluator evaluator(asset);
                evaluator.transfer()->usePath(path);
                evaluator.transfer()->setLight(light);
                evaluator.setFrame(1);
                std::vector<Vec3> found(vertices);
                evaluator.transfer()->irradiance(0, vertices, found);
                set.reflect(0, vertices, found);
                for (std::size_t v = 0; v < vertices; ++v)
                    for (int channel = 0; channel < 3; ++channel) {
                        double sum = 0;
                        for (std::size_t c = 0; c < n; ++c) sum += double(light[c][channel]) * transfer[v * 36 + c];
                        ASSERT_NEAR(found[v][channel], double(kAlbedo[channel]) * sum / std::numbers::pi, 4e-6)
                            << path.name << " light order " << light_order << " vertex " << v;
                    }
            }
        }
}

// The numbers, the truth and other callers shade by the same rule, from any eye.
TEST(TransferAsset, ShadingOfNumbersIsThatOfTheLightFirst) {
    const std::vector<std::byte> bytes = packed(tubeTransfer(TransferModelKind::kPca, 4, kLarge));
    const AssetView asset = openAsset(bytes);
    ShadingSet set(asset);
    set.setLightRotation({{0, 0, 1, 0, 1, 0, -1, 0, 0}});
    Evaluator evaluator(asset);
    evaluator.setFrame(2);
    const std::size_t vertices = evaluator.vertexCount();
    const std::vector<Vec3> shaded = PosedArrays(evaluator).shade(set, {0, 1, 4});
    std::vector<Vec3> lit(vertices);
    evaluator.transfer()->setLight(set.lightTables().sh());
    evaluator.transfer()->irradiance(0, vertices, lit);
    set.reflect(0, vertices, lit);
    for (std::size_t v = 0; v < vertices; ++v)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(shaded[v][c], lit[v][c], 4e-6) << v;
}

// An open point sees E = 1: its t_0 is sqrt(pi) / 2, the integral of the cosine times y_0.
TEST(TransferAsset, AmbientVisibilityIsOneWhereNothingBlocks) {
    TransferModel model = tubeTransfer(TransferModelKind::kLinear, 2);
    std::fill(model.weights.begin(), model.weights.end(), 0.0f);
    const std::size_t vertices = model.mesh.vertexCount(), bias = model.angles.size() * vertices;
    for (std::size_t v = 0; v < vertices; ++v) model.weights[bias + v] = float(std::sqrt(std::numbers::pi) / 2);
    const std::vector<std::byte> bytes = packed(model);
    const AssetView asset = openAsset(bytes);
    Evaluator evaluator(asset);
    evaluator.setFrame(0);
    std::vector<float> coefficients(vertices * std::size_t(asset.model.stride)), e(vertices);
    evaluator.evaluateCluster(0, coefficients);
    ambient(asset, coefficients, e);
    for (const float value : e) EXPECT_NEAR(value, 1, 1e-6);
}

// Rounding of the basis to halves and bytes, relative to the transfer's own size: measured 1.2e-4 and 1.9e-3.
TEST(TransferAsset, CoarserPrecisionsStayNear) {
    const TransferModel model = tubeTransfer(TransferModelKind::kPca, 6, kLarge);
    const auto evaluated = [&](AssetPrecision precision) {
        const std::vector<std::byte> bytes = packed(model, precision);
        const AssetView asset = openAsset(bytes);
        Evaluator evaluator(asset);
        evaluator.setFrame(1);
        return coefficientsOf(evaluator);
    };
    const std::vector<float> exact = evaluated(AssetPrecision::kF32);
    for (const auto& [precision, bound] : {std::pair(AssetPrecision::kF16, 4e-4), {AssetPrecision::kI8, 6e-3}}) {
        const std::vector<float> coarse = evaluated(precision);
        double error = 0, all = 0;
        for (std::size_t i = 0; i < exact.size(); ++i) {
            error += std::pow(double(coarse[i]) - exact[i], 2);
            all += std::pow(double(exact[i]), 2);
        }
        EXPECT_LT(std::sqrt(error / all), bound) << nameOf(precision);
        EXPECT_GT(error, 0) << nameOf(precision);
    }
}

TEST(TransferAsset, OnlyLambertMaterialsCanBeOn) {
    const TransferModel model = tubeTransfer(TransferModelKind::kPca, 2);
    BrdfFile glossy = diffuseMaterial({1, 1, 1});
    glossy.name = "glossy";
    glossy.lobes = {lobeOf(parseBrdf("ggx:alpha=0.3"))};
    const std::vector lights{synthetic::light(2, 0.1)};
    EXPECT_THROW(packTransfer(model, std::vector{glossy}, lights, {}, "{}"), Unsupported);
    const std::vector<std::byte> bytes =
        packTransfer(model, std::vector{diffuseMaterial({1, 1, 1}), glossy}, lights, {}, "{}");
    const AssetView asset = openAsset(bytes);
    const ShadingSet set(asset);
    EXPECT_TRUE(set.hasMaterial(0));
    EXPECT_FALSE(set.hasMaterial(1));
}

// The made material is the one that `penumbra-fit brdf --analytic lambert` makes: f cos = albedo cos / pi.
TEST(TransferAsset, DiffuseMaterialReflectsItsAlbedo) {
    const BrdfFile brdf = diffuseMaterial(kAlbedo);
    // Under uniform light of radiance 1, whose only coefficient is sqrt(4 pi), the radiance is the albedo.
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(std::sqrt(4 * std::numbers::pi) * brdf.slices[c] * 0.5 * std::numbers::inv_sqrtpi,
                    double(kAlbedo[int(c)]), 1e-6);
}

template <class Change>
std::string refusalAfter(const Change& change, TransferModelKind kind = TransferModelKind::kPca) {
    return refusalOf(packed(tubeTransfer(kind, 2)), change);
}

TEST(TransferAsset, WrongNumbersAreRefused) {
    const auto transfer = [](fbs::Asset& a) -> fbs::Transfer& { return *a.mutable_transfer(); };
    EXPECT_EQ(refusalAfter([](fbs::Asset&) {}), "accepted");
    const auto expect = [&](const char* part, const auto& change) {
        EXPECT_THAT(refusalAfter(change), HasSubstr(part));
    };
    expect("transfer.order", [&](fbs::Asset& a) { transfer(a).mutate_order(9); });
    expect("transfer.weights.count", [&](fbs::Asset& a) { transfer(a).mutate_order(3); });
    expect("transfer.angles[0] is 99", [&](fbs::Asset& a) { transfer(a).mutable_angles()->Mutate(0, 99); });
    expect("is not above the one before", [&](fbs::Asset& a) { transfer(a).mutable_angles()->Mutate(1, 0); });
    expect("transfer.alpha", [&](fbs::Asset& a) { transfer(a).mutate_alpha(-1); });
    expect("transfer.mean has a number", [&](fbs::Asset& a) { transfer(a).mutable_mean()->Mutate(0, NAN); });
    expect("transfer.pose_basis has a number",
           [&](fbs::Asset& a) { transfer(a).mutable_pose_basis()->Mutate(0, INFINITY); });
    expect("transfer.basis.count", [&](fbs::Asset& a) { transfer(a).mutable_basis()->mutate_count(31); });
    expect("transfer.basis is empty", [&](fbs::Asset& a) { transfer(a).mutable_basis()->mutate_count(3); });
    expect("transfer.weights.row_length", [&](fbs::Asset& a) { transfer(a).mutable_weights()->mutate_row_length(1); });
    expect("mesh.shading_point", [](fbs::Asset& a) {
        a.mutable_mesh()->mutable_shading_point()->Mutate(0, 1);
        a.mutable_mesh()->mutable_shading_point()->Mutate(1, 0);
    });
    expect("animation.pose", [](fbs::Asset& a) { a.mutable_animation()->mutate_pose_size(6); });
}

TEST(TransferAsset, EveryTruncationIsRefused) {
    expectTruncationsRefused(packed(tubeTransfer(TransferModelKind::kPca, 2, {.rings = 2, .segments = 3})), 7);
}

// With the hash put right, whatever the checks let through must be usable.
TEST(TransferAsset, MutationsAreRefusedOrUsable) {
    std::mt19937 random(23);
    int used = 0, refused = 0;
    for (const TransferModelKind kind : kTransferModelKinds) {
        const std::vector<std::byte> whole = packed(tubeTransfer(kind, 2, {.rings = 2, .segments = 3, .frames = 2}));
        for (int trial = 0; trial < 3000; ++trial) {
            std::vector<std::byte> bytes = whole;
            for (int i = 0; i < 2; ++i) bytes[random() % bytes.size()] ^= std::byte(1u << random() % 8);
            sealAsset(bytes);
            try {
                useAsset(openAsset(bytes));
                ++used;
            } catch (const InvalidInput&) {
                ++refused;
            }
        }
    }
    EXPECT_GT(used, 300);
    EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace penumbra::test_transfer_asset
