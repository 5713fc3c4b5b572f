#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/posed_vertices.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_dense.h"

namespace penumbra::test_dense_section {
namespace {

std::vector<std::byte> packedDense(Model model) {
    synthetic::addDense(model);
    return packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes;
}

// Brings numbers of convention B to another frame by way of the model frame.
std::vector<float> inFrame(std::span<const float> coefficients, const Mat3& from_local, const Mat3& to_local) {
    std::vector<float> model(coefficients.size()), out(coefficients.size());
    apply(makeShRotation(5, from_local), coefficients, model);
    apply(makeShRotation(5, to_local), model, out);
    return out;
}

// A follower has the weighted sum of its points, each turned with the smallest rotation of its normal to that of the
// follower, whatever their clusters are: across the border of two clusters there is no step.
TEST(DenseSection, FollowersHaveWhatTheirPointsHave) {
    const Model model = synthetic::tubeModel({.rings = 5, .clusters = 3, .convention = parseConvention("B5")});
    const std::vector<std::byte> bytes = packedDense(model);
    const AssetView asset = openAsset(bytes);
    ASSERT_EQ(asset.mesh.firstFollower(), model.mesh.vertexCount());
    ASSERT_EQ(asset.mesh.positions.size(), model.mesh.vertexCount() + model.mesh.triangles.size());
    Evaluator evaluator(asset);
    evaluator.setFrame(2);
    const PosedArrays posed(evaluator);
    const auto stride = std::size_t(asset.model.stride), size = std::size_t(asset.model.convention.size());
    std::size_t mixed = 0;
    for (std::size_t v = asset.mesh.firstFollower(); v < asset.mesh.positions.size(); ++v) {
        std::vector<float> expected(size);
        const auto& corners = asset.mesh.follower_corners[v - asset.mesh.firstFollower()];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t c = corners[i];
            const Vec3 tangent = carriedTangent(posed.normals[c], posed.normals[v], posed.tangents[c]);
            const Mat3 carried = toLocalFrame(posed.normals[v], tangent);
            const std::vector<float> turned =
                inFrame(std::span(posed.coefficients).subspan(c * stride, size), transposed(carried),
                        toLocalFrame(posed.normals[v], posed.tangents[v]));
            const float weight = asset.mesh.follower_weights[v - asset.mesh.firstFollower()][i];
            for (std::size_t j = 0; j < size; ++j) expected[j] += weight * turned[j];
        }
        for (std::size_t j = 0; j < size; ++j) EXPECT_NEAR(posed.coefficients[v * stride + j], expected[j], 2e-5);
        mixed += clusterAt(asset, corners[0]) != clusterAt(asset, corners[2]);
    }
    EXPECT_GT(mixed, 0u);
}

// Points are where they would be without followers, to the bit, composed models included.
TEST(DenseSection, PointsAreAsWithoutFollowers) {
    for (const Model& model : {synthetic::tubeModel({}), synthetic::composedTube({.joints = 4}, {})}) {
        const std::vector<std::byte> dense = packedDense(model),
                                     plain =
                                         packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes;
        const AssetView a = openAsset(dense), b = openAsset(plain);
        Evaluator of_dense(a), of_plain(b);
        of_dense.setFrame(1);
        of_plain.setFrame(1);
        const std::vector<float> x = coefficientsOf(of_dense), y = coefficientsOf(of_plain);
        EXPECT_TRUE(std::equal(y.begin(), y.end(), x.begin()));
        EXPECT_EQ(of_dense.outOfRange(), of_plain.outOfRange());
    }
}

TEST(DenseSection, LightThatBouncesIsRefused) {
    Model model = synthetic::tubeModel({});
    synthetic::addDense(model);
    model.indirect.emplace().clusters = model.clusters;
    EXPECT_THROW((void)packAsset(model, {}, {}, {}, "{}", 1), Unsupported);
}

TEST(DenseSection, ReaderRefusesBadTables) {
    const std::vector<std::byte> bytes = packedDense(synthetic::tubeModel({}));
    const AssetView asset = openAsset(bytes);
    const auto refused = [&](const void* place, auto value, const std::string& field) {
        std::vector<std::byte> copy = bytes;
        std::memcpy(copy.data() + (static_cast<const std::byte*>(place) - bytes.data()), &value, sizeof value);
        ASSERT_TRUE(sealAsset(copy));
        try {
            (void)openAsset(copy);
            ADD_FAILURE() << field;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
        }
    };
    refused(asset.mesh.follower_corners[1].data(), std::uint32_t(asset.mesh.firstFollower()), "mesh.point_corners");
    refused(asset.mesh.follower_weights[2].data(), -0.5f, "mesh.point_weights");
    refused(asset.mesh.follower_weights[2].data(), 1.5f, "mesh.point_weights");
}

}  // namespace
}  // namespace penumbra::test_dense_section
