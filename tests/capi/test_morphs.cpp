// Tests morph targets through the C API: weights by name.
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "tests/capi/use_c_api.h"
#include "tests/synthetic_morphs.h"

namespace penumbra::test_morphs {
namespace {

using namespace capi_test;

TEST(CApiMorphs, WeightsAreInputsByName) {
    const Model model = synthetic::morphTube();
    const std::vector<std::byte> bytes =
        packAsset(model, capi_test::materials(), lights(3), {.precision = AssetPrecision::kF32}, "{}", 1).bytes;
    const Asset asset = open(bytes);
    std::vector<float> rest(2);
    ASSERT_EQ(penumbra_asset_morph_count(asset.get(), rest.data()), 2u);
    EXPECT_EQ(penumbra_asset_morph_count(nullptr, nullptr), 0u);
    EXPECT_EQ(rest, (std::vector<float>{0.5f, 0}));
    const penumbra_asset_info info = infoOf(asset);
    const std::size_t frame = 3;
    penumbra_frame stored;
    ASSERT_EQ(penumbra_asset_get_frame(asset.get(), frame, &stored), PENUMBRA_OK);
    // The engine's bones, then the weights of the frame by name.
    std::vector<float> matrices(stored.matrices, stored.matrices + 12 * info.joint_count), inputs(info.input_count);
    std::fill(matrices.end() - 24, matrices.end(), 0.0f);
    inputs[penumbra_asset_find_input(asset.get(), "fat")] = synthetic::morphWeightsOf(frame)[0];
    inputs[penumbra_asset_find_input(asset.get(), "lean")] = synthetic::morphWeightsOf(frame)[1];
    penumbra_error error;
    ASSERT_EQ(penumbra_asset_input_matrices(asset.get(), PENUMBRA_ROWS_3X4, inputs.data(), inputs.size(),
                                            matrices.data(), info.joint_count, &error),
              PENUMBRA_OK);
    const Character character = capi_test::character(asset);
    ASSERT_EQ(penumbra_character_set_pose(character.get(), PENUMBRA_ROWS_3X4, matrices.data(), info.joint_count,
                                          nullptr, 0, &error),
              PENUMBRA_OK);
    std::vector<float> positions(3 * info.vertex_count), normals(positions), tangents(positions);
    penumbra_vertices vertices{};
    vertices.count = info.vertex_count;
    vertices.positions = positions.data();
    vertices.normals = normals.data();
    vertices.tangents = tangents.data();
    ASSERT_EQ(penumbra_character_skin(character.get(), &vertices, &error), PENUMBRA_OK);
    const RestShape expected = synthetic::morphedFrame(model, frame);
    for (std::size_t r = 0; r < info.source_vertex_count; ++r)
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(positions[3 * info.source_vertex[r] + std::size_t(axis)],
                        expected.positions[model.mesh.source_vertex[r]][axis], 3e-6);
}

}  // namespace
}  // namespace penumbra::test_morphs
