// Tests characters whose vertices are given: what the model reads of them, and what the vertices get.
#include <gtest/gtest.h>

#include "pack/pack_asset.h"
#include "player/view/playback/position_interpolation.h"
#include "runtime/evaluate/evaluator.h"
#include "sh/vertex_normals.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_deformation {
namespace {

using synthetic::ClothOptions;

struct PackedCloth {
    Model model;
    std::vector<std::byte> bytes;
    AssetView asset;

    explicit PackedCloth(const ClothOptions& options = {})
        : model(synthetic::clothModel(options)),
          bytes(packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes),
          asset(openAsset(bytes)) {}
    std::span<const Vec3> points(std::size_t frame) const {
        return std::span(model.positions).subspan(frame * asset.mesh.pointCount(), asset.mesh.pointCount());
    }
    std::span<const float> inputs(std::size_t frame) const { return asset.animation.inputsOf(frame); }
    std::size_t frames() const { return asset.animation.frameCount(); }
};

TEST(Deformation, BonesAreThoseOfTheFitBitByBit) {
    for (const bool two_sided : {false, true}) {
        const PackedCloth cloth({.two_sided = two_sided});
        Evaluator evaluator(cloth.asset);
        for (std::size_t f = 0; f < cloth.frames(); ++f) {
            evaluator.setPositions(cloth.points(f), cloth.inputs(f));
            for (std::size_t j = 0; j < 4; ++j) EXPECT_EQ(evaluator.bones()[j], cloth.model.bones[4 * f + j]);
        }
    }
}

TEST(Deformation, PositionsBonesAndPoseGiveTheSameNumbers) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals})
        for (const ModelKind kind : kModelKinds) {
            const PackedCloth cloth({.features = features, .kind = kind});
            Evaluator by_positions(cloth.asset), by_pose(cloth.asset);
            for (std::size_t f = 0; f < cloth.frames(); ++f) {
                by_positions.setPositions(cloth.points(f), cloth.inputs(f));
                const std::size_t size = std::size_t(cloth.model.pose_size);
                by_pose.setPose(std::span(cloth.model.bones).subspan(4 * f, 4),
                                std::span(cloth.model.pose).subspan(f * size, size));
                const std::vector<float> a = coefficientsOf(by_positions), b = coefficientsOf(by_pose);
                for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 2e-5f);  // measured: 3e-6
            }
        }
}

TEST(Deformation, NormalsAreOfTheFrontsAndBacksAreTheirOpposites) {
    const PackedCloth cloth;
    const MeshView& mesh = cloth.asset.mesh;
    Evaluator evaluator(cloth.asset);
    evaluator.setPositions(cloth.points(3), cloth.inputs(3));
    const PosedArrays v(evaluator);
    std::vector<Vec3> expected(mesh.pointCount());
    std::vector<Vec3d> scratch(mesh.pointCount());
    std::vector<std::uint32_t> triangles;
    for (std::size_t t = 0; t < cloth.model.mesh.frontTriangleCount(); ++t)
        for (std::uint32_t corner : cloth.model.mesh.triangles[t]) triangles.push_back(corner);
    vertexNormals(triangles, cloth.points(3), scratch, expected);
    for (std::size_t i = 0; i < v.positions.size(); ++i) {
        const std::size_t point = mesh.pointOf(i);
        EXPECT_EQ(v.positions[i], cloth.points(3)[point]);
        EXPECT_EQ(v.normals[i], mesh.isBack(i) ? -expected[point] : expected[point]);
        EXPECT_NEAR(dot(v.normals[i], v.tangents[i]), 0, 1e-6f);
        EXPECT_NEAR(dot(v.tangents[i], v.tangents[i]), 1, 1e-6f);
    }
}

// Parts, ball and sheet move together as one rigid body, so that nothing changes that a cluster sees of them. The
// number is no place in space, and stays.
TEST(Deformation, ARigidMotionOfEverythingChangesNoNumber) {
    const PackedCloth cloth;
    Evaluator still(cloth.asset), moved(cloth.asset);
    still.setPositions(cloth.points(2), cloth.inputs(2));
    const Affine motion{{0.36f, -0.48f, 0.8f, 3, 0.8f, 0.6f, 0, -1, -0.48f, 0.64f, 0.6f, 2}};
    std::vector<Vec3> points(cloth.points(2).begin(), cloth.points(2).end());
    for (Vec3& p : points) p = motion.point(p);
    std::vector<float> inputs(cloth.inputs(2).begin(), cloth.inputs(2).end());
    const Vec3 ball = motion.point({inputs[1], inputs[2], inputs[3]});
    for (int i = 0; i < 3; ++i) inputs[std::size_t(1 + i)] = ball[i];
    moved.setPositions(points, inputs);
    const std::vector<float> a = coefficientsOf(still), b = coefficientsOf(moved);
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 2e-4f);
    inputs[0] += 0.5f;
    moved.setPositions(points, inputs);
    EXPECT_NE(coefficientsOf(moved), b) << "the number is read";
    inputs[0] -= 0.5f;
    inputs[2] += 0.3f;
    moved.setPositions(points, inputs);
    EXPECT_NE(coefficientsOf(moved), b) << "the ball is read";
}

TEST(Deformation, AFrameIsItsPlaybackPositions) {
    const PackedCloth cloth;
    Evaluator by_frame(cloth.asset), by_positions(cloth.asset);
    std::vector<Vec3> points(cloth.asset.mesh.pointCount());
    for (std::size_t f = 0; f < cloth.frames(); ++f) {
        by_frame.setFrame(f);
        readPositions(cloth.asset, f, points);
        by_positions.setPositions(points, cloth.inputs(f));
        EXPECT_EQ(coefficientsOf(by_frame), coefficientsOf(by_positions));
        EXPECT_EQ(PosedArrays(by_frame).positions, PosedArrays(by_positions).positions);
    }
}

TEST(Deformation, RestIsWhereNoBoneMoves) {
    const PackedCloth cloth;
    Evaluator evaluator(cloth.asset);
    const Deformation& deformation = *evaluator.deformation();
    evaluator.setPositions(deformation.rest(), deformation.restInputs());
    for (const Affine& bone : evaluator.bones())
        for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(bone.m[i], Affine().m[i], 1e-6f);
}

TEST(Deformation, NothingIsAllocatedPerFrame) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const PackedCloth cloth({.features = features});
        Evaluator evaluator(cloth.asset);
        PositionInterpolation between(cloth.asset);
        const std::size_t before = allocationCount();
        for (std::size_t f = 0; f + 1 < cloth.frames(); ++f) {
            evaluator.setFrame(f);
            between.evaluate(f, f + 1, 0.3);
            evaluator.setPositions(between.points(), between.inputs());
        }
        EXPECT_EQ(allocationCount(), before);
    }
}

TEST(PositionInterpolation, IsTheFramesAtBothEndsAndTheirMeanBetween) {
    const PackedCloth cloth;
    std::vector<Vec3> a(cloth.asset.mesh.pointCount()), b(a.size());
    readPositions(cloth.asset, 1, a);
    readPositions(cloth.asset, 2, b);
    PositionInterpolation between(cloth.asset);
    between.evaluate(1, 2, 0);
    EXPECT_TRUE(std::ranges::equal(between.points(), a));
    EXPECT_TRUE(std::ranges::equal(between.inputs(), cloth.inputs(1)));
    between.evaluate(1, 2, 1);
    EXPECT_TRUE(std::ranges::equal(between.points(), b));
    EXPECT_TRUE(std::ranges::equal(between.inputs(), cloth.inputs(2)));
    between.evaluate(1, 2, 0.5);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(length(between.points()[i] - (a[i] + b[i]) * 0.5f), 1e-6f);
    EXPECT_NEAR(between.inputs()[0], 0.5f * (cloth.inputs(1)[0] + cloth.inputs(2)[0]), 1e-6f);
}

}  // namespace
}  // namespace penumbra::test_deformation
