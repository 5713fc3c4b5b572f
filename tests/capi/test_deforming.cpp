// Tests characters whose vertices the engine gives: results equal those of the C++ classes, errors, and no
// allocation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "formats/common/errors.h"
#include "runtime/evaluate/evaluator.h"
#include "tests/capi/use_c_api.h"
#include "tests/posed_vertices.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_deforming {
namespace {

using namespace capi_test;
using testing::HasSubstr;

struct Cloth {
    Model model;
    std::vector<std::byte> bytes;
    Asset asset;
    Character character;
    penumbra_asset_info info;
    penumbra_error error;

    explicit Cloth(const synthetic::ClothOptions& options = {}, bool playback = true)
        : model(synthetic::clothModel(options)),
          bytes(packAsset(model, capi_test::materials(), lights(3),
                          {.precision = AssetPrecision::kI8, .playback = playback}, "{}", 1)
                    .bytes),
          asset(open(bytes)),
          character(capi_test::character(asset)),
          info(infoOf(asset)) {}

    std::span<const Vec3> points(std::size_t frame) const {
        const std::size_t count = model.mesh.frontVertexCount();
        return std::span(model.positions).subspan(frame * count, count);
    }
    // Positions in the order of the source, in which the cloth's are backwards.
    std::vector<float> source(std::size_t frame) const {
        std::vector<float> out;
        for (std::uint32_t v : model.mesh.source_vertex) {
            const Vec3 p = points(frame)[v];
            out.insert(out.end(), {p.x, p.y, p.z});
        }
        return out;
    }
    penumbra_status set(penumbra_vertex_order order, const std::vector<float>& positions,
                        const std::vector<float>& inputs) {
        return penumbra_character_set_positions(character.get(), order, positions.data(), positions.size() / 3,
                                                inputs.data(), inputs.size(), &error);
    }
};

TEST(CApiDeforming, SaysWhatTheAssetIs) {
    const Cloth cloth;
    EXPECT_EQ(cloth.info.deforming, 1);
    EXPECT_EQ(cloth.info.two_sided, 1);
    EXPECT_EQ(cloth.info.has_playback, 1);
    EXPECT_EQ(cloth.info.vertex_count, 2 * cloth.info.source_vertex_count);
    ASSERT_EQ(cloth.info.input_count, 4u);
    EXPECT_STREQ(penumbra_asset_input_name(cloth.asset.get(), 1), "ball.x");
    EXPECT_EQ(penumbra_asset_input_name(cloth.asset.get(), 4), nullptr);
    EXPECT_EQ(penumbra_asset_find_input(cloth.asset.get(), "ball.z"), 3u);
    EXPECT_EQ(penumbra_asset_find_input(cloth.asset.get(), "ball"), PENUMBRA_NONE);
    penumbra_frame frame;
    ASSERT_EQ(penumbra_asset_get_frame(cloth.asset.get(), 2, &frame), PENUMBRA_OK);
    EXPECT_EQ(frame.matrices, nullptr);
    EXPECT_EQ(frame.inputs[0], synthetic::clothInputs(2 / 3.0)[0]);
    const std::vector<std::byte> tube = packed();
    const Asset skinned = open(tube);
    EXPECT_EQ(infoOf(skinned).deforming, 0);
    EXPECT_EQ(infoOf(skinned).input_count, 0u);
    ASSERT_EQ(penumbra_asset_get_frame(skinned.get(), 0, &frame), PENUMBRA_OK);
    EXPECT_EQ(frame.inputs, nullptr);
    EXPECT_EQ(Cloth({.two_sided = false}, false).info.two_sided, 0);
    EXPECT_EQ(Cloth({}, false).info.has_playback, 0);
}

TEST(CApiDeforming, SameNumbersAsTheClassesInEitherOrder) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals})
        for (const ModelKind kind : kModelKinds) {
            Cloth cloth({.features = features, .kind = kind});
            const AssetView view = openAsset(cloth.bytes);
            Evaluator evaluator(view);
            Frame frame(cloth.info);
            for (std::size_t f = 0; f < cloth.info.frame_count; ++f) {
                const std::vector<float> inputs = synthetic::clothInputs(f / 3.0);
                evaluator.setPositions(cloth.points(f), inputs);
                const auto [positions, normals, tangents, coefficients, indirect] = PosedArrays(evaluator);
                std::vector<float> asset_order;
                for (std::size_t v = 0; v < positions.size(); ++v)
                    for (int i = 0; i < 3; ++i)
                        asset_order.push_back(view.mesh.isBack(v) ? std::numeric_limits<float>::quiet_NaN()
                                                                  : positions[v][i]);
                for (const bool source : {true, false}) {
                    ASSERT_EQ(cloth.set(source ? PENUMBRA_SOURCE_VERTICES : PENUMBRA_ASSET_VERTICES,
                                        source ? cloth.source(f) : asset_order, inputs),
                              PENUMBRA_OK)
                        << cloth.error.message;
                    ASSERT_EQ(frame.evaluate(cloth.character.get(), cloth.info, 3), PENUMBRA_OK);
                    EXPECT_EQ(frame.coefficients, coefficients);
                    for (std::size_t v = 0; v < positions.size(); ++v)
                        for (std::size_t i = 0; i < 3; ++i) {
                            ASSERT_EQ(frame.positions[3 * v + i], positions[v][int(i)]);
                            ASSERT_EQ(frame.normals[3 * v + i], normals[v][int(i)]);
                            ASSERT_EQ(frame.tangents[3 * v + i], tangents[v][int(i)]);
                        }
                    EXPECT_EQ(penumbra_character_out_of_range(cloth.character.get()), evaluator.outOfRange());
                }
            }
        }
}

TEST(CApiDeforming, ACharacterBeginsAtRest) {
    const Cloth cloth;
    Frame frame(cloth.info);
    ASSERT_EQ(frame.evaluate(cloth.character.get(), cloth.info), PENUMBRA_OK);
    EXPECT_EQ(std::vector<float>(cloth.info.rest_positions, cloth.info.rest_positions + 3 * cloth.info.vertex_count),
              frame.positions);
}

TEST(CApiDeforming, WrongCallsAreRefused) {
    Cloth cloth;
    const std::vector<float> source = cloth.source(1), inputs = synthetic::clothInputs(0);
    const auto said = [&](penumbra_status status) {
        EXPECT_EQ(status, cloth.error.status);
        return std::string(penumbra_status_name(status)) + ": " + cloth.error.message;
    };
    const auto set = [&](penumbra_vertex_order order, const std::vector<float>& positions,
                         const std::vector<float>& x) { return said(cloth.set(order, positions, x)); };
    EXPECT_EQ(set(PENUMBRA_ASSET_VERTICES, source, inputs),
              "PENUMBRA_INVALID_ARGUMENT: vertex_count is 30; the asset has 60 vertices");
    EXPECT_EQ(set(PENUMBRA_SOURCE_VERTICES, {0, 0, 0}, inputs),
              "PENUMBRA_INVALID_ARGUMENT: vertex_count is 1; the asset has 30 source vertices");
    EXPECT_THAT(set(penumbra_vertex_order(2), source, inputs), HasSubstr("order is no penumbra_vertex_order"));
    EXPECT_THAT(set(PENUMBRA_SOURCE_VERTICES, source, {1, 2, 3}), HasSubstr("input_count is 3; the asset has 4"));
    std::vector<float> wrong = inputs;
    wrong[2] = std::numeric_limits<float>::infinity();
    EXPECT_THAT(set(PENUMBRA_SOURCE_VERTICES, source, wrong), HasSubstr("inputs[2] is not finite"));
    wrong = source;
    wrong[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(set(PENUMBRA_SOURCE_VERTICES, wrong, inputs), HasSubstr("positions[7] is not finite"));
    penumbra_character* c = cloth.character.get();
    penumbra_error* e = &cloth.error;
    EXPECT_THAT(said(penumbra_character_set_positions(c, PENUMBRA_SOURCE_VERTICES, nullptr, 30, inputs.data(), 4, e)),
                HasSubstr("positions is NULL"));
    EXPECT_THAT(said(penumbra_character_set_positions(c, PENUMBRA_SOURCE_VERTICES, source.data(), 30, nullptr, 4, e)),
                HasSubstr("inputs is NULL"));
    const std::vector<float> matrices(12 * cloth.info.joint_count, 0.0f), rotations(3 * cloth.info.joint_count);
    EXPECT_THAT(
        said(penumbra_character_set_pose(c, PENUMBRA_ROWS_3X4, matrices.data(), cloth.info.joint_count, nullptr, 0, e)),
        HasSubstr("PENUMBRA_UNSUPPORTED: asset: is a deforming mesh"));
    EXPECT_THAT(said(penumbra_character_set_rotations(c, nullptr, rotations.data(), rotations.size(), e)),
                HasSubstr("PENUMBRA_UNSUPPORTED: asset: is a deforming mesh"));
    Cloth quiet({}, false);
    EXPECT_EQ(penumbra_character_set_frame(quiet.character.get(), 0, e), PENUMBRA_UNSUPPORTED);
    const std::vector<std::byte> tube = packed();
    const Asset skinned = open(tube);
    const Character bones = character(skinned);
    EXPECT_EQ(penumbra_character_set_positions(bones.get(), PENUMBRA_SOURCE_VERTICES, source.data(), 30, nullptr, 0, e),
              PENUMBRA_UNSUPPORTED);
}

TEST(CApiDeforming, AVertexWithoutSourceIsSaidSo) {
    Model model = synthetic::clothModel();
    for (std::uint32_t& v : model.mesh.source_vertex) v = 3;
    const std::vector<std::byte> bytes = packAsset(model, {}, {}, {.precision = AssetPrecision::kI8}, "{}", 1).bytes;
    const Asset asset = open(bytes);
    const Character c = character(asset);
    const std::vector<float> positions(3 * 30), inputs(4);
    EXPECT_EQ(penumbra_character_set_positions(c.get(), PENUMBRA_SOURCE_VERTICES, positions.data(), 30, inputs.data(),
                                               4, nullptr),
              PENUMBRA_UNSUPPORTED);
}

TEST(CApiDeforming, NothingIsAllocatedPerFrame) {
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        Cloth cloth({.features = features});
        const std::vector<float> source = cloth.source(2), inputs = synthetic::clothInputs(1);
        Frame frame(cloth.info);
        const std::size_t before = allocationCount();
        int status = 0;
        for (std::size_t f = 0; f < 100; ++f) {
            status |= penumbra_character_set_frame(cloth.character.get(), f % cloth.info.frame_count, nullptr);
            status |= cloth.set(PENUMBRA_SOURCE_VERTICES, source, inputs);
            status |= frame.evaluate(cloth.character.get(), cloth.info, 2);
        }
        EXPECT_EQ(status, PENUMBRA_OK);
        EXPECT_EQ(allocationCount(), before);
    }
}

TEST(CApiDeforming, HostileBytesAreRefusedOrUsable) {
    std::mt19937 random(23);
    int refused = 0, used = 0;
    for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
        const Cloth cloth({.features = features});
        for (int trial = 0; trial < 1000; ++trial) {
            std::vector<std::byte> bytes = cloth.bytes;
            for (int i = 0; i < 1 + int(random() % 4); ++i) bytes[random() % bytes.size()] = std::byte(random());
            sealAsset(bytes);
            const penumbra_status status = useBytes(bytes.data(), bytes.size(), nullptr);
            ASSERT_TRUE(status == PENUMBRA_OK || status == PENUMBRA_INVALID_ASSET);
            ++(status == PENUMBRA_OK ? used : refused);
        }
    }
    EXPECT_GT(refused, 100);
    EXPECT_GT(used, 100);
}

}  // namespace
}  // namespace penumbra::test_deforming
