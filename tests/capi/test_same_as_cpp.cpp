// The C interface gives what the C++ classes give, to the bit: it adds checks and nothing else.
#include <gtest/gtest.h>

#include <cstring>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "tests/capi/packed_asset.h"
#include "tests/difference.h"
#include "tests/posed_vertices.h"

extern "C" std::size_t sizes_seen_by_c(void);

namespace penumbra::test_same_as_cpp {
namespace {

using namespace capi_test;

std::vector<float> floatsOf(const std::vector<Vec3>& vectors) {
    std::vector<float> out;
    for (const Vec3& v : vectors) out.insert(out.end(), {v.x, v.y, v.z});
    return out;
}

// Expects what the C++ classes compute for a frame of the asset.
void expectSame(const Frame& frame, Evaluator& evaluator, const ShadingSet& set, std::size_t number) {
    const AssetView& asset = evaluator.asset();
    evaluator.setPose(asset.animation.bonesOf(number), asset.animation.poseOf(number));
    const PosedArrays expected(evaluator);
    std::vector<float> e(frame.ambient.size());
    ambient(asset, expected.coefficients, e);
    EXPECT_EQ(frame.positions, floatsOf(expected.positions));
    EXPECT_EQ(frame.normals, floatsOf(expected.normals));
    EXPECT_EQ(frame.tangents, floatsOf(expected.tangents));
    EXPECT_EQ(frame.coefficients, expected.coefficients);
    EXPECT_EQ(frame.ambient, e);
    EXPECT_EQ(frame.radiance, floatsOf(expected.shade(set, {0.5f, 1, 3})));
}

TEST(CApi, HeaderMeansTheSameInC) {
    EXPECT_EQ(sizes_seen_by_c(), sizeof(penumbra_error) + sizeof(penumbra_asset_info) + sizeof(penumbra_clip) +
                                     sizeof(penumbra_frame) + sizeof(penumbra_material) + sizeof(penumbra_light) +
                                     sizeof(penumbra_cluster) + sizeof(penumbra_shading_options) +
                                     sizeof(penumbra_vertices) + sizeof(penumbra_lobe) + sizeof(penumbra_sun) +
                                     sizeof(penumbra_sun_caster));
}

TEST(CApi, SameNumbersAsTheClasses) {
    for (const FeatureKind features : synthetic::kSkinnedFeatures)
        for (const ModelKind kind : kModelKinds)
            for (const AssetPrecision precision : {AssetPrecision::kF32, AssetPrecision::kF16, AssetPrecision::kI8}) {
                Recipe recipe{.precision = precision};
                recipe.tube.features = features;
                recipe.tube.kind = kind;
                const std::vector<std::byte> bytes = packed(recipe);
                const AssetView view = openAsset(bytes);
                Evaluator evaluator(view);
                const ShadingSet set(view);
                const Asset asset = open(bytes);
                ASSERT_TRUE(asset);
                const Character character = capi_test::character(asset);
                const Shading shading = capi_test::shading(asset);
                const penumbra_asset_info info = infoOf(asset);
                Frame frame(info);
                for (std::size_t f = 0; f < info.frame_count; ++f) {
                    ASSERT_EQ(penumbra_character_set_frame(character.get(), f, nullptr), PENUMBRA_OK);
                    EXPECT_EQ(frame.evaluate(character.get(), info, f + 1), PENUMBRA_OK);
                    EXPECT_EQ(frame.shade(shading.get(), 0, info.vertex_count), PENUMBRA_OK);
                    expectSame(frame, evaluator, set, f);
                    EXPECT_EQ(penumbra_character_out_of_range(character.get()), evaluator.outOfRange());
                }
            }
}

TEST(CApi, EveryReflectanceLightFormAndPathIsThatOfTheClasses) {
    const std::vector<std::byte> bytes = packed();
    const AssetView view = openAsset(bytes);
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    const penumbra_asset_info info = infoOf(asset);
    const LightForm forms[] = {LightForm::kRotation, LightForm::kFixed, LightForm::kLobes};
    for (int reflectance : {0, 1})
        for (int form : {0, 1, 2})
            for (const penumbra_simd simd : {PENUMBRA_SIMD_PORTABLE, PENUMBRA_SIMD_AVX2}) {
                if (!penumbra_has_simd(simd)) continue;
                const penumbra_shading_options options{penumbra_reflectance(reflectance), penumbra_light_form(form), 0};
                const Shading shading = capi_test::shading(asset, options);
                ASSERT_TRUE(shading);
                ASSERT_EQ(penumbra_character_set_simd(character.get(), simd, nullptr), PENUMBRA_OK);
                ASSERT_EQ(penumbra_shading_set_simd(shading.get(), simd, nullptr), PENUMBRA_OK);
                Evaluator evaluator(view);
                ShadingSet set(view, {Reflectance(reflectance), forms[form]});
                if (reflectance == 1) set.setMaterial(1);  // "lambert" has no operators
                if (form == 2) set.setLight(1);            // "uniform" has no lobes
                const bool portable = simd == PENUMBRA_SIMD_PORTABLE;
                evaluator.usePath(evaluatorPaths()[portable ? 0 : 1]);
                set.usePath(shadePaths()[portable ? 0 : 1]);
                Frame frame(info);
                penumbra_character_set_frame(character.get(), 1, nullptr);
                EXPECT_EQ(frame.evaluate(character.get(), info), PENUMBRA_OK);
                EXPECT_EQ(frame.shade(shading.get(), 0, 11), PENUMBRA_OK);
                EXPECT_EQ(frame.shade(shading.get(), 11, info.vertex_count - 11), PENUMBRA_OK);
                expectSame(frame, evaluator, set, 1);
            }
}

TEST(CApi, SwitchesAsTheClassesDo) {
    const std::vector<std::byte> bytes = packed();
    const AssetView view = openAsset(bytes);
    Evaluator evaluator(view);
    ShadingSet set(view);
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    const Shading shading = capi_test::shading(asset);
    const penumbra_asset_info info = infoOf(asset);
    EXPECT_EQ(penumbra_shading_slot_count(shading.get()), 2u);
    EXPECT_EQ(penumbra_shading_material_count(shading.get()), 2u);
    EXPECT_EQ(penumbra_shading_light_count(shading.get()), 2u);
    Frame frame(info);
    penumbra_character_set_frame(character.get(), 2, nullptr);
    frame.evaluate(character.get(), info);
    const auto expectNow = [&](const char* what) {
        SCOPED_TRACE(what);
        EXPECT_EQ(frame.shade(shading.get(), 0, info.vertex_count), PENUMBRA_OK);
        expectSame(frame, evaluator, set, 2);
    };
    expectNow("the asset's choice");
    EXPECT_EQ(penumbra_shading_set_material(shading.get(), 0, 1, nullptr), PENUMBRA_OK);
    set.setMaterial(0, 1);
    expectNow("a material of a slot");
    EXPECT_EQ(penumbra_shading_set_light(shading.get(), 1, nullptr), PENUMBRA_OK);
    set.setLight(1);
    expectNow("a light of another order");
    const float turn[9] = {0.6f, 0, 0.8f, 0, 1, 0, -0.8f, 0, 0.6f};
    EXPECT_EQ(penumbra_shading_set_light_rotation(shading.get(), turn, nullptr), PENUMBRA_OK);
    set.setLightRotation({{0.6f, 0, 0.8f, 0, 1, 0, -0.8f, 0, 0.6f}});
    expectNow("a turned light");
    EXPECT_EQ(penumbra_shading_set_material(shading.get(), PENUMBRA_ALL_SLOTS, 0, nullptr), PENUMBRA_OK);
    set.setMaterial(0);
    expectNow("one material for all");
}

// When the caller gives a light of the asset as coefficients, it is that light, also turned, and also when its order
// is lower than there is room for.
TEST(CApi, ALightOfTheCallerIsALightLikeAnother) {
    const std::vector<std::byte> bytes = packed();
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    const Shading shading = capi_test::shading(asset, {PENUMBRA_SLICES, PENUMBRA_ROTATION, 6});
    const penumbra_asset_info info = infoOf(asset);
    ASSERT_EQ(penumbra_shading_light_count(shading.get()), 3u);
    Frame frame(info);
    frame.evaluate(character.get(), info);
    const float turn[9] = {1, 0, 0, 0, 0.6f, -0.8f, 0, 0.8f, 0.6f};
    penumbra_shading_set_light_rotation(shading.get(), turn, nullptr);
    for (const std::size_t index : {1, 0}) {  // the second leaves nothing of the first, which has more bands
        penumbra_light light;
        ASSERT_EQ(penumbra_asset_get_light(asset.get(), index, &light), PENUMBRA_OK);
        ASSERT_EQ(penumbra_shading_set_light(shading.get(), index, nullptr), PENUMBRA_OK);
        frame.shade(shading.get(), 0, info.vertex_count);
        const std::vector<float> expected = frame.radiance;
        ASSERT_EQ(penumbra_shading_set_sh_light(shading.get(), light.order, light.sh, 0, nullptr), PENUMBRA_OK);
        frame.shade(shading.get(), 0, info.vertex_count);
        EXPECT_LT(largestDifference(frame.radiance, expected), 2e-6) << index;  // other orders, other order of sums
    }
}

// Materials and lights of another file follow the asset's own.
TEST(CApi, MaterialsAndLightsOfOtherFiles) {
    const std::vector<std::byte> bare = packed({.materials = false, .lights = false});
    const std::vector<std::byte> other = packed({.seed = 11}), whole = packed({.seed = 11});
    const Asset asset = open(bare), more = open(other), both = open(whole);
    const penumbra_asset* list[] = {more.get()};
    penumbra_shading* made = nullptr;
    EXPECT_EQ(penumbra_shading_create(asset.get(), nullptr, 0, nullptr, &made, nullptr), PENUMBRA_UNSUPPORTED);
    ASSERT_EQ(penumbra_shading_create(asset.get(), list, 1, nullptr, &made, nullptr), PENUMBRA_OK);
    const Shading shading(made), expected_shading = capi_test::shading(both);
    penumbra_shading_set_material(shading.get(), 1, 1, nullptr);
    const Character character = capi_test::character(asset);
    const penumbra_asset_info info = infoOf(asset);
    Frame frame(info);
    frame.evaluate(character.get(), info);
    frame.shade(expected_shading.get(), 0, info.vertex_count);
    const std::vector<float> expected = frame.radiance;
    std::fill(frame.radiance.begin(), frame.radiance.end(), -7.0f);
    frame.shade(shading.get(), 0, info.vertex_count);
    EXPECT_EQ(frame.radiance, expected);
}

// Computes what a GPU computes from the queries: mean + sum of score * scale * basis, before the ambient term is
// clamped.
TEST(CApi, ClustersAndScoresAreAllThatTheNumbersNeed) {
    const std::vector<std::byte> bytes = packed({.precision = AssetPrecision::kF32});
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    penumbra_character_set_frame(character.get(), 1, nullptr);
    const penumbra_asset_info info = infoOf(asset);
    Frame frame(info);
    frame.evaluate(character.get(), info);
    std::vector<float> scores(info.score_count, -7), rotations(9 * info.cluster_count, -7);
    ASSERT_EQ(penumbra_character_get_scores(character.get(), scores.data(), rotations.data()), PENUMBRA_OK);
    std::size_t scores_seen = 0, vertices_seen = 0;
    for (std::size_t c = 0; c < info.cluster_count; ++c) {
        penumbra_cluster cluster;
        ASSERT_EQ(penumbra_asset_get_cluster(asset.get(), c, &cluster), PENUMBRA_OK);
        EXPECT_EQ(cluster.first_score, scores_seen);
        EXPECT_EQ(cluster.first_vertex, vertices_seen);
        ASSERT_EQ(cluster.basis_precision, PENUMBRA_F32);
        ASSERT_EQ(cluster.basis_scale, nullptr);
        const std::size_t count = cluster.vertex_count * info.stride;
        for (std::size_t i = 0; i < count; ++i) {
            float sum = static_cast<const float*>(cluster.mean)[i];
            for (std::size_t k = 0; k < cluster.component_count; ++k)
                sum += scores[cluster.first_score + k] * static_cast<const float*>(cluster.basis)[k * count + i];
            EXPECT_NEAR(sum, frame.coefficients[cluster.first_vertex * info.stride + i], 1e-5);
        }
        double determinant_minus_one = 0;
        const float* r = rotations.data() + 9 * c;
        for (int i = 0; i < 3; ++i)
            determinant_minus_one += double(r[i]) * (double(r[3 + (i + 1) % 3]) * r[6 + (i + 2) % 3] -
                                                     double(r[3 + (i + 2) % 3]) * r[6 + (i + 1) % 3]);
        EXPECT_NEAR(determinant_minus_one, 1, 1e-5);
        scores_seen += cluster.component_count;
        vertices_seen += cluster.vertex_count;
    }
    EXPECT_EQ(scores_seen, info.score_count);
    EXPECT_EQ(vertices_seen, info.vertex_count);
}

TEST(CApi, EveryLayoutOfMatricesIsTheSamePose) {
    Recipe recipe;
    recipe.tube.features = FeatureKind::kJointAngles;
    const std::vector<std::byte> bytes = packed(recipe);
    const Asset asset = open(bytes);
    const penumbra_asset_info info = infoOf(asset);
    ASSERT_EQ(info.rotation_count, 3 * info.joint_count);
    penumbra_frame stored;
    ASSERT_EQ(penumbra_asset_get_frame(asset.get(), 2, &stored), PENUMBRA_OK);
    std::vector<float> columns(16 * info.joint_count, NAN);  // the last row of each is not read
    for (std::size_t j = 0; j < info.joint_count; ++j)
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 4; ++column)
                columns[16 * j + 4 * column + row] = stored.matrices[12 * j + 4 * row + column];
    const Character character = capi_test::character(asset);
    const auto frameAfter = [&](penumbra_status status) {
        EXPECT_EQ(status, PENUMBRA_OK);
        Frame frame(info);
        frame.evaluate(character.get(), info);
        frame.coefficients.insert(frame.coefficients.end(), frame.positions.begin(), frame.positions.end());
        return frame.coefficients;
    };
    const auto rest = frameAfter(PENUMBRA_OK);
    const auto expected = frameAfter(penumbra_character_set_frame(character.get(), 2, nullptr));
    EXPECT_NE(rest, expected);
    EXPECT_EQ(expected, frameAfter(penumbra_character_set_pose(character.get(), PENUMBRA_ROWS_3X4, stored.matrices,
                                                               info.joint_count, stored.rotations, info.rotation_count,
                                                               nullptr)));
    penumbra_character_set_frame(character.get(), 0, nullptr);
    EXPECT_EQ(expected, frameAfter(penumbra_character_set_pose(character.get(), PENUMBRA_COLUMNS_4X4, columns.data(),
                                                               info.joint_count, stored.rotations, info.rotation_count,
                                                               nullptr)));
}

// A character starts in the rest pose, so positions are those of the asset.
TEST(CApi, StartsInTheRestPose) {
    const std::vector<std::byte> bytes = packed();
    const Asset asset = open(bytes);
    const penumbra_asset_info info = infoOf(asset);
    const Character character = capi_test::character(asset);
    Frame frame(info);
    frame.evaluate(character.get(), info);
    for (std::size_t i = 0; i < frame.positions.size(); ++i) {
        EXPECT_NEAR(frame.positions[i], info.rest_positions[i], 1e-6);
        EXPECT_NEAR(frame.normals[i], info.rest_normals[i], 1e-6);
    }
}

// A turn of angle a about a unit axis has the log a * axis. Rest comes first, then the turn in the joint's own frame.
TEST(CApi, RotationVectorsAreLogsRelativeToRest) {
    const float half = float(0.5 * std::sqrt(2.0)), rest[4] = {0, half, 0, half};
    float out[3];
    penumbra_rotation_vector(rest, rest, out);
    for (const float v : out) EXPECT_EQ(v, 0);
    for (const double angle : {1e-4, 0.5, 3.1}) {
        const double s = std::sin(angle / 2), c = std::cos(angle / 2);
        // This is (0, h, 0, h) * (s, 0, 0, c).
        const float now[4] = {float(half * s), float(half * c), float(-half * s), float(half * c)};
        const float opposite[4] = {-now[0], -now[1], -now[2], -now[3]};
        for (const float* q : {now, opposite}) {
            penumbra_rotation_vector(rest, q, out);
            EXPECT_NEAR(out[0], angle, 1e-6);
            EXPECT_NEAR(out[1], 0, 1e-6);
            EXPECT_NEAR(out[2], 0, 1e-6);
        }
    }
}

}  // namespace
}  // namespace penumbra::test_same_as_cpp
