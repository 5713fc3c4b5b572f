// Tests deforming and two-sided meshes and inputs: what is packed, and that nothing wrong gets past the reader.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "asset_generated.h"
#include "formats/asset/asset_file.h"
#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "pack/sections/asset_writer.h"
#include "runtime/evaluate/evaluator.h"
#include "tests/difference.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_cloth.h"
#include "tests/use_asset.h"

namespace penumbra::test_deforming_asset {
namespace {

using synthetic::ClothOptions;

std::vector<std::byte> packedCloth(const ClothOptions& cloth = {}, bool playback = true) {
    const std::vector<BrdfFile> brdfs = {synthetic::lambert()};
    const std::vector<LightFile> lights = {synthetic::light(4, 0.3)};
    const PackOptions options{.precision = AssetPrecision::kF16, .playback = playback};
    return packAsset(synthetic::clothModel(cloth), brdfs, lights, options, "{}", 1).bytes;
}

TEST(DeformingAsset, HoldsFrontsBacksInputsAndPlayback) {
    for (const bool two_sided : {false, true}) {
        const ClothOptions cloth{.two_sided = two_sided};
        const Model model = synthetic::clothModel(cloth);
        const std::vector<std::byte> bytes = packedCloth(cloth);
        const AssetView asset = openAsset(bytes);
        const MeshView& mesh = asset.mesh;
        EXPECT_TRUE(asset.model.deforming);
        EXPECT_EQ(mesh.two_sided, two_sided);
        ASSERT_EQ(mesh.pointCount(), 30u);
        EXPECT_EQ(mesh.positions.size(), two_sided ? 60u : 30u);
        EXPECT_EQ(mesh.frontTriangles().size(), 3u * 40);
        std::size_t backs = 0;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            backs += mesh.isBack(v);
            EXPECT_EQ(mesh.positions[v], model.mesh.rest_positions[mesh.pointOf(v)]);
            EXPECT_EQ(mesh.normals[v].y, mesh.isBack(v) ? -1 : 1);
        }
        EXPECT_EQ(backs, two_sided ? 30u : 0u);
        ASSERT_EQ(asset.animation.input_names.size(), 4u);
        EXPECT_EQ(asset.animation.input_names[3], "ball.z");
        EXPECT_EQ(asset.animation.inputsOf(2)[1], synthetic::clothInputs(2 / 3.0)[1]);
        ASSERT_EQ(asset.model.input_joints.size(), 2u);
        EXPECT_EQ(asset.model.input_joints[0].column, 1u);
        EXPECT_FALSE(asset.model.input_joints[0].absolute());
        EXPECT_TRUE(asset.model.input_joints[1].absolute());
        EXPECT_EQ(asset.model.input_joints[1].scale, 0.4f);
        EXPECT_TRUE(asset.animation.bones.empty()) << "they follow from the positions";
    }
}

// The bound is half a step in each direction, and the rounding of floats.
TEST(DeformingAsset, PlaybackIsAsNearAsItSays) {
    const Model model = synthetic::clothModel();
    const std::vector<std::byte> bytes = packedCloth();
    const AssetView asset = openAsset(bytes);
    const PlaybackView& playback = asset.animation.playback;
    Largest worst;
    std::vector<Vec3> points(asset.mesh.pointCount());
    for (std::size_t f = 0; f < asset.animation.frameCount(); ++f) {
        readPositions(asset, f, points);
        for (std::size_t s = 0; s < points.size(); ++s)
            worst.add(length(toDouble(points[s]) - toDouble(model.positions[f * points.size() + s])));
    }
    EXPECT_LE(worst, playback.error);
    EXPECT_GT(worst, 0.99 * playback.error) << "the bound is measured, not guessed";
    EXPECT_LT(playback.error, 0.87f * playback.step);
    EXPECT_LT(playback.step, 3.0f / 65535);
}

TEST(DeformingAsset, PlaybackCanBeLeftOut) {
    const std::vector<std::byte> with = packedCloth(), without = packedCloth({}, false);
    const AssetView asset = openAsset(without);
    EXPECT_TRUE(asset.animation.playback.positions.empty());
    EXPECT_EQ(asset.animation.frameCount(), 5u);
    EXPECT_LE(without.size() + 5 * 30 * 6, with.size());
    std::size_t listed = 0;
    for (const SizeOf& size : sectionSizes(openAsset(with), with.size()))
        if (size.section == "playback") listed = size.bytes;
    EXPECT_EQ(listed, 5u * 30 * 6);
    EXPECT_NEAR(double(modelBytes(openAsset(with), with.size())), double(modelBytes(asset, without.size())), 100)
        << "but for the layout";
}

TEST(DeformingAsset, FramesOfSkinnedOnesCanBeLeftOut) {
    const Model model = synthetic::tubeModel();
    const PackOptions without{.precision = AssetPrecision::kF16, .playback = false};
    const std::vector<std::byte> all = packAsset(model, {}, {}, {.precision = AssetPrecision::kF16}, "{}", 1).bytes,
                                 bytes = packAsset(model, {}, {}, without, "{}", 1).bytes;
    const AssetView whole = openAsset(all), asset = openAsset(bytes);
    EXPECT_EQ(asset.animation.frameCount(), 0u);
    EXPECT_TRUE(asset.animation.clips.empty() && asset.animation.bones.empty() && asset.animation.pose.empty());
    EXPECT_EQ(asset.animation.jointCount(), whole.animation.jointCount());
    EXPECT_LT(bytes.size() + whole.animation.bones.size_bytes(), all.size());
    Evaluator evaluator(asset), expected(whole);
    evaluator.setPose(whole.animation.bonesOf(1), whole.animation.poseOf(1));
    expected.setFrame(1);
    std::vector<float> coefficients(evaluator.vertexCount() * std::size_t(asset.model.stride)),
        same(coefficients.size());
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
        evaluator.evaluateCluster(c, coefficients);
        expected.evaluateCluster(c, same);
    }
    EXPECT_EQ(largestDifference(coefficients, same), 0);
    EXPECT_GT(largestMagnitude(coefficients), 0.3);
}

TEST(DeformingAsset, SkinnedOnesHaveNoPlayback) {
    const std::vector<std::byte> bytes = packAsset(synthetic::tubeModel(), {}, {}, {}, "{}", 1).bytes;
    for (const SizeOf& size : sectionSizes(openAsset(bytes), 0)) EXPECT_NE(size.section, "playback");
}

TEST(DeformingAsset, DihedralPoseIsPacked) {
    const ClothOptions cloth{.features = FeatureKind::kDihedrals, .kind = ModelKind::kLinear};
    const Model model = synthetic::clothModel(cloth);
    const std::vector<std::byte> bytes = packedCloth(cloth);
    const AssetView asset = openAsset(bytes);
    EXPECT_EQ(asset.animation.pose_size, 7u);
    EXPECT_EQ(asset.model.pose_mean.size(), model.pose_mean.size());
    EXPECT_EQ(asset.model.pose_basis.count, model.pose_basis.size());
}

// --- What is refused ---

template <class Change>
std::string refusalAfter(const Change& change, const ClothOptions& cloth = {}) {
    return refusalOf(packedCloth(cloth), change);
}

void expectSays(const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message << " should say " << part;
}

TEST(DeformingAsset, NamesTheFieldThatIsWrong) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    using fbs::Asset;
    EXPECT_EQ(refusalAfter([](Asset&) {}), "accepted");
    expectSays(refusalAfter([](Asset& a) { a.mutable_mesh()->mutable_positions()->Mutate(0, 9.0f); }),
               "that is elsewhere");
    expectSays(refusalAfter(
                   [](Asset& a) { a.mutable_mesh()->mutable_normals()->Mutate(1, a.mesh()->normals()->Get(1) * -1); }),
               "negated normal");
    expectSays(refusalAfter([](Asset& a) {
                   auto* t = a.mutable_mesh()->mutable_triangles();
                   t->Mutate(0, t->Get(t->size() / 2));
               }),
               "mesh.triangles[0] is the back");
    expectSays(refusalAfter([](Asset& a) {
                   auto* t = a.mutable_mesh()->mutable_triangles();
                   const auto last = t->size() - 1;
                   t->Mutate(last, t->Get(last - 1));
               }),
               "from behind");
    expectSays(refusalAfter([](Asset& a) {
                   a.mutable_mesh()->mutable_source_vertex()->Mutate(0, a.mesh()->triangles()->Get(130));
               }),
               "source_vertex[0] is the back");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_animation()->mutable_inputs()->Mutate(2, nan); }),
               "animation.inputs");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_animation()->mutable_positions_origin()->Mutate(2, nan); }),
               "positions_origin");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_animation()->mutate_positions_step(-1); }), "positions_step");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_animation()->mutate_positions_error(INFINITY); }),
               "positions_error");
    const auto input = [](Asset& a, unsigned i) {
        return const_cast<fbs::InputJoint*>(a.mutable_model()->mutable_input_joints()->GetMutableObject(i));
    };
    expectSays(refusalAfter([&](Asset& a) { input(a, 0)->mutate_joint(4); }), "input_joints[0].joint");
    expectSays(refusalAfter([&](Asset& a) { input(a, 0)->mutate_joint(3); }), "input_joints[0].joint");
    expectSays(refusalAfter([&](Asset& a) { input(a, 0)->mutate_column(2); }), "input_joints[0].column");
    expectSays(refusalAfter([&](Asset& a) { input(a, 0)->mutate_columns(2); }), "neither 1 nor 3");
    expectSays(refusalAfter([&](Asset& a) { input(a, 1)->mutate_scale(nan); }), "input_joints[1].scale");
    expectSays(refusalAfter([&](Asset& a) { input(a, 1)->mutate_offset(nan); }), "input_joints[1].offset");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_mesh()->mutable_skin_joints()->Mutate(3, 2); }),
               "mesh.skin_joints[3]");
    expectSays(refusalAfter([&](Asset& a) { a.mutable_model()->mutate_deforming(false); }), "animation.bones");
}

TEST(DeformingAsset, NamesWhatIsWrongWithDihedralAngles) {
    const ClothOptions cloth{.features = FeatureKind::kDihedrals, .kind = ModelKind::kLinear};
    using fbs::Asset;
    EXPECT_EQ(refusalAfter([](Asset&) {}, cloth), "accepted");
    expectSays(refusalAfter([](Asset& a) { a.mutable_model()->mutable_pose_mean()->Mutate(0, NAN); }, cloth),
               "model.pose_mean");
    expectSays(refusalAfter([](Asset& a) { a.mutable_animation()->mutate_pose_size(6); }, cloth), "pose_basis.count");
    expectSays(refusalAfter([](Asset& a) { a.mutable_animation()->mutate_pose_size(3); }, cloth), "model.pose_mean");
    expectSays(refusalAfter([](Asset& a) { a.mutable_animation()->mutate_pose_size(4000000000u); }, cloth),
               "model.pose_mean");
    expectSays(
        refusalAfter([](Asset& a) { a.mutable_model()->mutate_features(fbs::FeatureKind::RelativeBones); }, cloth),
        "pose_mean");
    // Another fold of the mesh has another number of inner edges.
    expectSays(refusalAfter(
                   [](Asset& a) {
                       auto* t = a.mutable_mesh()->mutable_triangles();
                       for (unsigned i = 0; i < 3; ++i) t->Mutate(i, t->Get(30 + i));
                       const unsigned back = t->size() / 2;
                       for (unsigned i = 0; i < 3; ++i) t->Mutate(back + i, t->Get(back + 30 + i));
                   },
                   cloth),
               "model.pose_mean has");
}

TEST(DeformingAsset, RejectsEveryTruncationAndUsesOrRefusesMutations) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const std::vector<std::byte> whole = packedCloth({.features = features});
        expectTruncationsRefused(whole, 7);
        std::mt19937 random(11);
        int refused = 0, used = 0;
        for (int trial = 0; trial < 3000; ++trial) {
            std::vector<std::byte> bytes = whole;
            for (int i = 0; i < 1 + int(random() % 4); ++i) bytes[random() % bytes.size()] = std::byte(random());
            sealAsset(bytes);
            try {
                useAsset(openAsset(bytes));
                ++used;
            } catch (const InvalidInput&) {
                ++refused;
            }
        }
        EXPECT_GT(refused, 300);
        EXPECT_GT(used, 300);
    }
}

TEST(DeformingAsset, RefusesPositionsThatAreNotFinite) {
    Model model = synthetic::clothModel();
    model.positions[7].y = NAN;
    EXPECT_THROW(packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1), InvalidInput);
    EXPECT_EQ(quantizePositions(std::vector<Vec3>(4, {1, 2, 3})).step, 0) << "all in one place";
}

}  // namespace
}  // namespace penumbra::test_deforming_asset
