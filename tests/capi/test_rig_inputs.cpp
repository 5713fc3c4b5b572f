// Tests rigs that were baked with --inputs: joints that stand for the inputs come after the rig's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/evaluate/evaluator.h"
#include "sh/rigid_fit.h"
#include "tests/capi/use_c_api.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_rig_inputs {
namespace {

using namespace capi_test;
using testing::HasSubstr;

constexpr std::size_t kTubeJoints = 3, kJoints = kTubeJoints + 2, kBall = kTubeJoints, kWind = kTubeJoints + 1;

// Adds "wind", then the point "ball", to the pose and as joints that move no vertex, as the fit writes them.
void addInputsToFrames(Model& model) {
    std::vector<Affine> bones;
    std::vector<float> pose;
    const auto pose_size = std::size_t(model.pose_size);
    for (std::size_t f = 0; f < model.frames.frameCount(); ++f) {
        const std::vector<float> x = synthetic::clothInputs(double(f) / 3);
        const auto bone = model.bones.begin() + long(f * kTubeJoints);
        bones.insert(bones.end(), bone, bone + kTubeJoints);
        bones.push_back(pointBone({x[1], x[2], x[3]}, model.joint_centers[kBall]));
        bones.push_back(numberBone(x[0], 2.5f, 0.4f));
        const auto number = model.pose.begin() + long(f * pose_size);
        pose.insert(pose.end(), number, number + long(pose_size));
        pose.insert(pose.end(), x.begin(), x.end());
    }
    model.bones = bones;
    model.pose = pose;
    model.pose_size += 4;
}

Model tubeWithInputs(FeatureKind features, ModelKind kind) {
    const synthetic::TubeOptions options{.joints = int(kTubeJoints), .features = features, .kind = kind};
    Model model;
    model.convention = options.convention;
    model.features = features;
    model.kind = kind;
    model.feature_scale = 2;
    synthetic::addTube(model, options);
    synthetic::addFrames(model, options);
    for (const char* name : {"ball", "wind"}) {
        model.skin.joint_names.push_back(name);
        model.skin.parents.push_back(-1);
        model.skin.rest_transforms.push_back({});
        model.skin.inverse_bind.push_back({});
        model.joint_spreads.push_back({{}});
    }
    model.joint_centers.push_back({0.1f, 0.5f, 0.2f});
    model.joint_centers.push_back({});
    model.input_names = {"wind", "ball.x", "ball.y", "ball.z"};
    model.input_joints = {{kBall, 1, 3, 0, 1}, {kWind, 0, 1, 2.5f, 0.4f}};
    addInputsToFrames(model);
    synthetic::addClusters(model, options);
    model.provenance = {"test", "0", "{}", {}};
    return model;
}

struct Rig {
    std::vector<std::byte> bytes;
    Asset asset;
    Character character;
    penumbra_asset_info info;
    penumbra_error error;

    explicit Rig(FeatureKind features, ModelKind kind = ModelKind::kAdditive)
        : bytes(packAsset(tubeWithInputs(features, kind), {}, {}, {.precision = AssetPrecision::kI8}, "{}", 1).bytes),
          asset(open(bytes)),
          character(capi_test::character(asset)),
          info(infoOf(asset)) {}

    penumbra_frame frame(std::size_t number) const {
        penumbra_frame stored;
        EXPECT_EQ(penumbra_asset_get_frame(asset.get(), number, &stored), PENUMBRA_OK);
        return stored;
    }
    // Evaluates a frame whose matrices may have been changed.
    Frame evaluated(const std::vector<float>& matrices, const float* rotations) {
        EXPECT_EQ(penumbra_character_set_pose(character.get(), PENUMBRA_ROWS_3X4, matrices.data(), kJoints, rotations,
                                              info.rotation_count, &error),
                  PENUMBRA_OK)
            << error.message;
        Frame out(info);
        EXPECT_EQ(out.evaluate(character.get(), info), PENUMBRA_OK);
        return out;
    }
};

TEST(CApiRigInputs, AreJointsBehindTheRigsOwn) {
    const Rig rig(FeatureKind::kRelativeBones);
    EXPECT_EQ(rig.info.deforming, 0);
    ASSERT_EQ(rig.info.input_count, 4u);
    ASSERT_EQ(rig.info.joint_count, kJoints);
    EXPECT_EQ(rig.info.rotation_count, 0u);
    EXPECT_EQ(penumbra_asset_find_joint(rig.asset.get(), "ball"), kBall);
    EXPECT_EQ(penumbra_asset_find_input(rig.asset.get(), "ball.z"), 3u);
    const std::vector<float> expected = synthetic::clothInputs(2 / 3.0);
    const penumbra_frame frame = rig.frame(2);
    EXPECT_EQ(std::vector<float>(frame.inputs, frame.inputs + 4), expected);
    const float* ball = frame.matrices + 12 * kBall;  // translated from its center
    EXPECT_FLOAT_EQ(ball[3], expected[1] - 0.1f);
    EXPECT_FLOAT_EQ(ball[0], 1);
    EXPECT_FLOAT_EQ(frame.matrices[12 * kWind + 3], (expected[0] - 2.5f) * 0.4f);
    EXPECT_EQ(Rig(FeatureKind::kJointAngles).info.rotation_count, 3 * kTubeJoints + 4);
}

// Compares penumbra_character_set_frame(), penumbra_character_set_pose() with what the frame holds, and the C++ class.
TEST(CApiRigInputs, SameNumbersAsTheClasses) {
    for (const FeatureKind features : synthetic::kSkinnedFeatures)
        for (const ModelKind kind : kModelKinds) {
            Rig rig(features, kind);
            const AssetView view = openAsset(rig.bytes);
            Evaluator evaluator(view);
            for (std::size_t f = 0; f < rig.info.frame_count; ++f) {
                evaluator.setFrame(f);
                Frame by_frame(rig.info);
                const std::vector<float> coefficients = coefficientsOf(evaluator);
                ASSERT_EQ(penumbra_character_set_frame(rig.character.get(), f, nullptr), PENUMBRA_OK);
                ASSERT_EQ(by_frame.evaluate(rig.character.get(), rig.info), PENUMBRA_OK);
                EXPECT_EQ(by_frame.coefficients, coefficients);
                const penumbra_frame stored = rig.frame(f);
                const Frame by_pose =
                    rig.evaluated({stored.matrices, stored.matrices + 12 * kJoints}, stored.rotations);
                EXPECT_EQ(by_pose.coefficients, coefficients);
                EXPECT_EQ(by_pose.positions, by_frame.positions);
            }
        }
}

// From the inputs of a frame come its matrices of their joints, in either layout. Nothing else is touched.
TEST(CApiRigInputs, MatricesOfInputsAreThoseOfTheFrame) {
    const Rig rig(FeatureKind::kRelativeBones);
    for (std::size_t f = 0; f < rig.info.frame_count; ++f) {
        const penumbra_frame stored = rig.frame(f);
        std::vector<float> rows(stored.matrices, stored.matrices + 12 * kJoints), columns(16 * kJoints, 7.0f);
        std::fill_n(rows.begin() + 12 * kBall, 24, 7.0f);
        ASSERT_EQ(penumbra_asset_input_matrices(rig.asset.get(), PENUMBRA_ROWS_3X4, stored.inputs, 4, rows.data(),
                                                kJoints, nullptr),
                  PENUMBRA_OK);
        EXPECT_EQ(rows, std::vector<float>(stored.matrices, stored.matrices + 12 * kJoints));
        ASSERT_EQ(penumbra_asset_input_matrices(rig.asset.get(), PENUMBRA_COLUMNS_4X4, stored.inputs, 4, columns.data(),
                                                kJoints, nullptr),
                  PENUMBRA_OK);
        for (std::size_t j = 0; j < kJoints; ++j)
            for (std::size_t i = 0; i < 16; ++i) {
                const float there = i % 4 == 3 ? float(i == 15) : stored.matrices[12 * j + 4 * (i % 4) + i / 4];
                EXPECT_EQ(columns[16 * j + i], j < kBall ? 7.0f : there) << j << ' ' << i;
            }
    }
}

// Each input changes what is seen, and moves no vertex.
TEST(CApiRigInputs, MoveShadowsAndNoVertex) {
    Rig rig(FeatureKind::kRelativeBones);
    const penumbra_frame stored = rig.frame(1);
    const std::vector<float> matrices(stored.matrices, stored.matrices + 12 * kJoints);
    const Frame before = rig.evaluated(matrices, nullptr);
    for (const std::size_t joint : {kBall, kWind}) {
        std::vector<float> moved = matrices;
        moved[12 * joint + 3] += 0.3f;
        const Frame after = rig.evaluated(moved, nullptr);
        EXPECT_NE(after.coefficients, before.coefficients) << joint;
        EXPECT_EQ(after.positions, before.positions) << joint;
    }
}

TEST(CApiRigInputs, OtherPosesAreRefused) {
    Rig rig(FeatureKind::kRelativeBones);
    const std::vector<float> rotations(3 * kJoints), positions(3 * rig.info.source_vertex_count), inputs(4);
    penumbra_character* c = rig.character.get();
    EXPECT_EQ(penumbra_character_set_rotations(c, nullptr, rotations.data(), rotations.size(), &rig.error),
              PENUMBRA_UNSUPPORTED);
    EXPECT_THAT(rig.error.message, HasSubstr("joints that stand for inputs"));
    EXPECT_EQ(penumbra_character_set_positions(c, PENUMBRA_SOURCE_VERTICES, positions.data(), positions.size() / 3,
                                               inputs.data(), 4, &rig.error),
              PENUMBRA_UNSUPPORTED);
    std::vector<float> matrices(12 * kJoints);
    const auto write = [&](const Asset& asset, const float* x, std::size_t count, std::size_t joints) {
        return penumbra_asset_input_matrices(asset.get(), PENUMBRA_ROWS_3X4, x, count, matrices.data(), joints,
                                             &rig.error);
    };
    EXPECT_EQ(write(rig.asset, inputs.data(), 3, kJoints), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(write(rig.asset, nullptr, 4, kJoints), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(write(rig.asset, inputs.data(), 4, kTubeJoints), PENUMBRA_INVALID_ARGUMENT);
    const std::vector<std::byte> cloth = packAsset(synthetic::clothModel(), {}, {}, {}, "{}", 1).bytes;
    EXPECT_EQ(write(open(cloth), inputs.data(), 4, 4), PENUMBRA_UNSUPPORTED);
    const penumbra_frame stored = rig.frame(0);
    EXPECT_EQ(penumbra_character_set_pose(c, PENUMBRA_ROWS_3X4, stored.matrices, kTubeJoints, nullptr, 0, &rig.error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_THAT(rig.error.message, HasSubstr("joint_count is 3; the asset has 5"));
}

}  // namespace
}  // namespace penumbra::test_rig_inputs
