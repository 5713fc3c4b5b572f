// The visibility of a vertex of a composed asset, taken apart, and the boxes of its fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "player/frame/field_boxes.h"
#include "player/frame/visibility_factors.h"
#include "player/frame/visibility_lobe.h"
#include "runtime/shade/shading.h"
#include "sh/mirrored_product.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_visibility_factors {
namespace {

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

// A composed asset in the last of its frames, which is bent most.
struct Bent {
    Packed packed;
    AssetView asset;
    Evaluator evaluator;

    explicit Bent(const Model& model, AssetPrecision precision = AssetPrecision::kF32)
        : packed(packAsset(model, {}, {}, {.precision = precision}, "{}", 1)),
          asset(openAsset(packed.bytes)),
          evaluator(asset) {
        evaluator.setFrame(asset.animation.frameCount() - 1);
    }
};

const VisibilityFactor& factorOf(const std::vector<VisibilityFactor>& factors, FactorKind kind) {
    return *std::ranges::find(factors, kind, [](const VisibilityFactor& f) { return f.choice.kind; });
}

// Measured: 4e-7 for floats; a basis of bytes is combined with weights of 16 bits, 4e-5.
TEST(VisibilityFactors, LocalTimesFarAndTheResidualAreTheWhole) {
    for (const auto& [precision, bound] : {std::pair(AssetPrecision::kF32, 5e-6f), {AssetPrecision::kI8, 3e-4f}}) {
        Bent bent(synthetic::composedTube(kTube), precision);
        std::size_t unclamped = 0;
        for (std::size_t v = 0; v < bent.evaluator.vertexCount(); v += 7) {
            const std::vector<VisibilityFactor> factors = visibilityFactors(bent.evaluator, v);
            const VisibilityFactor &whole = factorOf(factors, FactorKind::kWhole),
                                   &local = factorOf(factors, FactorKind::kLocal),
                                   &far = factorOf(factors, FactorKind::kFar),
                                   &residual = factorOf(factors, FactorKind::kResidual);
            if (whole.ambient < 1e-3f || whole.ambient > 0.999f) continue;
            ++unclamped;
            std::vector<float> product(whole.coefficients.size());
            multiplyMirrored(whole.convention.order, local.coefficients, local.convention.order, far.coefficients,
                             kFieldOrder, product);
            for (std::size_t i = 0; i < product.size(); ++i)
                EXPECT_NEAR(product[i] + residual.coefficients[i], whole.coefficients[i], bound) << v << " " << i;
        }
        EXPECT_GT(unclamped, 10u);
    }
}

// The run time multiplies the parts at a grid of directions; here they are multiplied one after the other, and every
// product is cut to 6 bands. E differs by 0.003 at most.
TEST(VisibilityFactors, PartsMultiplyToTheFarOneAndDarkOnesComeFirst) {
    Bent bent(synthetic::composedTube(kTube));
    std::size_t with_parts = 0;
    for (std::size_t v = 0; v < bent.evaluator.vertexCount(); v += 7) {
        const std::vector<VisibilityFactor> factors = visibilityFactors(bent.evaluator, v);
        std::vector<float> product(kFarCoefficients), next(kFarCoefficients);
        product[0] = float(std::sqrt(4 * std::numbers::pi));
        float before = -1;
        for (const VisibilityFactor& factor : factors) {
            if (factor.choice.kind != FactorKind::kPart) continue;
            ++with_parts;
            EXPECT_GE(factor.ambient, before);
            before = factor.ambient;
            EXPECT_EQ(visibilityFactor(bent.evaluator, v, factor.choice).coefficients, factor.coefficients);
            multiplyMirrored(kFieldOrder, product, kFieldOrder, factor.coefficients, kFieldOrder, next);
            product = next;
        }
        std::vector<float> weights(kFarCoefficients);
        ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
        const float e = std::inner_product(weights.begin(), weights.end(), product.begin(), 0.0f);
        EXPECT_NEAR(e, factorOf(factors, FactorKind::kFar).ambient, 0.01) << v;
    }
    EXPECT_GT(with_parts, 20u);
}

TEST(VisibilityFactors, WhatAnAssetHasNotIsRefused) {
    Bent bent(synthetic::composedTube(kTube, {.residual = false}));
    const std::span<const std::uint16_t> part_of = bent.asset.model.composition->part_of_vertex;
    EXPECT_THROW(visibilityFactor(bent.evaluator, 0, {FactorKind::kPart, part_of[0]}), UsageError) << "its own part";
    EXPECT_THROW(visibilityFactor(bent.evaluator, 0, {FactorKind::kResidual}), UsageError);
    for (const VisibilityFactor& factor : visibilityFactors(bent.evaluator, 0))
        EXPECT_NE(factor.choice.kind, FactorKind::kResidual);
    EXPECT_EQ(parseFactor(bent.asset, "local"), FactorChoice{FactorKind::kLocal});
    EXPECT_EQ(parseFactor(bent.asset, "joint3"), (FactorChoice{FactorKind::kPart, 3}));
    EXPECT_THROW(parseFactor(bent.asset, "joint"), UsageError) << "begins six names";
    EXPECT_THROW(parseFactor(bent.asset, "arm"), UsageError);
    EXPECT_EQ(nameOf(bent.asset, {FactorKind::kPart, 3}), "far: joint3");

    Bent plain(synthetic::tubeModel(kTube));
    const std::vector<VisibilityFactor> factors = visibilityFactors(plain.evaluator, 5);
    ASSERT_EQ(factors.size(), 1u);
    EXPECT_EQ(factors[0].choice, FactorChoice());
    EXPECT_EQ(parseFactor(plain.asset, "whole"), FactorChoice());
    EXPECT_THROW(parseFactor(plain.asset, "joint1"), UsageError);
    EXPECT_THROW(visibilityFactor(plain.evaluator, 5, {FactorKind::kLocal}), UsageError);
}

TEST(FieldBoxes, MoveWithTheirBones) {
    Bent bent(synthetic::composedTube(kTube));
    const CompositionView& composition = *bent.asset.model.composition;
    const std::vector<std::size_t> parts = {4, 1};
    const std::vector<BoxEdge> edges = fieldBoxEdges(composition, bent.evaluator.bones(), parts);
    ASSERT_EQ(edges.size(), 48u);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const BoxEdge& edge = edges[i];
        EXPECT_EQ(edge.part, parts[i / 24]);
        EXPECT_EQ(edge.fine, i % 24 < 12);
        const PartField& field = composition.parts[edge.part].field;
        const FieldBox& box = field.boxes[edge.fine ? 0 : 1];
        // At rest both ends are corners of the box, and one coordinate of the two differs.
        const Affine to_part = bent.evaluator.posedParts()[edge.part].to_part;
        const Vec3 from = to_part.point(edge.from), to = to_part.point(edge.to);
        int apart = 0;
        for (int axis = 0; axis < 3; ++axis) {
            for (const float at : {from[axis], to[axis]})
                EXPECT_LT(std::min(std::abs(at - box.low[axis]), std::abs(at - box.high[axis])), 1e-5f);
            apart += std::abs(from[axis] - to[axis]) > 1e-4f;
        }
        EXPECT_EQ(apart, 1);
    }
}

TEST(FieldBoxes, CirclesLieOnTheirSpheres) {
    const std::array spheres = {CasterSphere{{1, 2, 3}, 0.5f}, CasterSphere{{0, 0, 0}, 2}};
    const std::array<std::uint16_t, 2> joints = {1, 0};
    const std::array bones = {Affine{}, Affine{{2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 0}}};
    const std::vector<BoxEdge> edges = sphereEdges({spheres, joints}, bones);
    ASSERT_EQ(edges.size(), 2u * 3 * 32);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool first = i < edges.size() / 2;
        const Vec3 center = first ? Vec3{7, 4, 6} : Vec3{};
        EXPECT_EQ(edges[i].part, first ? 1u : 0u);
        for (const Vec3 end : {edges[i].from, edges[i].to}) EXPECT_NEAR(length(end - center), first ? 1 : 2, 1e-5);
    }
}

TEST(FieldBoxes, RibbonsFaceTheEyeAndLookAsWideEverywhere) {
    const std::vector<BoxEdge> edges = {{{0, 0, 0}, {1, 0, 0}, 3, true}, {{0, 0, -8}, {0, 2, -9}, 5, true}};
    const Vec3 eye{0.5f, 0, 2};
    const Shape ribbons = edgeRibbons(edges, eye);
    ASSERT_EQ(ribbons.positions.size(), 8u);
    ASSERT_EQ(ribbons.triangles.size(), 12u);
    float share = 0;
    for (std::size_t i = 0; i < 8; i += 2) {
        const Vec3 across = ribbons.positions[i + 1] - ribbons.positions[i];
        const Vec3 end = (ribbons.positions[i + 1] + ribbons.positions[i]) * 0.5f;
        EXPECT_NEAR(dot(across, eye - end) / length(across), 0, 1e-3);
        if (i > 0) {
            EXPECT_NEAR(length(across) / length(eye - end), share, 1e-5);
        }
        share = length(across) / length(eye - end);
        EXPECT_EQ(ribbons.values[i].x, i < 4 ? 3 : 5);
    }
    EXPECT_GT(share, 0.001f);
    // An edge that points at the eye has no width, but its numbers are finite.
    for (const Vec3& p : edgeRibbons(std::vector<BoxEdge>{{{0, 0, 0}, {0, 0, 1}, 0, true}}, {0, 0, 2}).positions)
        EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
}

// -y_00 is negative everywhere.
TEST(SignedLobe, ShowsNegativeFunctionsInTheirOwnColour) {
    const Convention convention = parseConvention("D5");
    std::vector<float> coefficients(std::size_t(convention.size()));
    coefficients[0] = -0.2f * std::sqrt(4 * std::numbers::pi_v<float>);
    Shape lobe = signedLobe(convention, coefficients, toLocalFrame({0, 0, 1}, {1, 0, 0}), {}, 2);
    Largest farthest;
    for (const Vec3& p : lobe.positions) farthest.add(length(p));
    EXPECT_NEAR(farthest, 0.4f, 1e-5f);
    shadeSignedLobe(lobe, {0, 0, 5});
    for (std::size_t i = 0; i < lobe.values.size(); ++i)
        if (lobe.positions[i].z > 0.1f) {
            EXPECT_GT(lobe.values[i].x, lobe.values[i].y) << "red";
        }
}

}  // namespace
}  // namespace penumbra::test_visibility_factors
