// Compares the picked vertex, its lobe and the PCA components with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "player/frame/visibility_lobe.h"
#include "player/view/vertex_figures.h"
#include "player/view/view_pick.h"
#include "tests/difference.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_view_pick {
namespace {

using player_test::SyntheticAsset;

TEST(PickVertex, NearestCornerOfTheNearestTriangle) {
    const std::vector<Vec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    const std::vector<std::uint32_t> triangles = {0, 1, 2, 3, 4, 5};
    MeshView mesh;
    mesh.triangles = triangles;
    double distance = 0;
    const auto from = [&](Vec3d origin, Vec3d direction) {
        return pickVertex(positions, mesh, origin, direction, distance);
    };
    EXPECT_EQ(from({0.7, 0.2, 5}, {0, 0, -1}), 4u);
    EXPECT_NEAR(distance, 4, 1e-12);
    EXPECT_EQ(from({0.2, 0.7, -5}, {0, 0, 2}), 2u) << "from behind";
    EXPECT_NEAR(distance, 2.5, 1e-12) << "in lengths of the direction";
    EXPECT_EQ(from({0.7, 0.7, 5}, {0, 0, -1}), std::nullopt) << "beside";
    EXPECT_EQ(from({0.2, 0.2, 5}, {0, 0, 1}), std::nullopt) << "behind the eye";
    EXPECT_EQ(from({0.2, 0.2, 5}, {1, 0, 0}), std::nullopt) << "along the plane";
}

// V is 1 everywhere above the horizon, mirrored: number (0,0) is sqrt(4 pi), and every other one is 0.
TEST(VisibilityLobe, UnoccludedIsAHalfSphere) {
    const Convention convention = parseConvention("D5");
    std::vector<float> coefficients(std::size_t(convention.size()));
    coefficients[0] = std::sqrt(4 * std::numbers::pi_v<float>);
    const Vec3 normal{0, 0, 1}, tangent{1, 0, 0}, center{1, 2, 3};
    const Shape lobe = visibilityLobe(convention, coefficients, toLocalFrame(normal, tangent), center, 0.5f);
    Largest highest;
    for (std::size_t i = 0; i < lobe.positions.size(); ++i) {
        const Vec3 from_center = lobe.positions[i] - center;
        if (lobe.values[i].x > 0) {
            EXPECT_NEAR(length(from_center), 0.5, 1e-5);
            EXPECT_NEAR(lobe.values[i].x, 1, 1e-5);
            EXPECT_GE(from_center.z, -1e-5);
        } else {
            EXPECT_EQ(length(from_center), 0);
        }
        highest.add(from_center.z);
    }
    EXPECT_NEAR(highest, 0.5, 1e-5);
}

TEST(VisibilityLobe, ColoursAreFiniteAndWithinTheDisplay) {
    const Convention convention = parseConvention("D5");
    std::vector<float> coefficients(std::size_t(convention.size()), 0.7f);
    Shape lobe = visibilityLobe(convention, coefficients, toLocalFrame({0, 1, 0}, {0, 0, 1}), {}, 1);
    shadeLobe(lobe, {0, 5, 0});
    for (const Vec3& c : lobe.values)
        for (int i = 0; i < 3; ++i) EXPECT_TRUE(c[i] >= 0 && c[i] <= 1) << c[i];
}

// y_2,-2 ~ x y: the lobe leans where x y > 0 in the local frame, which is turned to the model's y z here.
TEST(VisibilityLobe, TurnsWithTheLocalFrame) {
    const Convention convention = parseConvention("D3");
    const std::vector<int> indices = convention.indices();
    std::vector<float> coefficients(indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) coefficients[i] = indices[i] == shIndex(2, -2) ? 1 : 0;
    const Shape lobe = visibilityLobe(convention, coefficients, toLocalFrame({1, 0, 0}, {0, 1, 0}), {}, 1);
    for (const Vec3& p : lobe.positions) EXPECT_GE(p.y * p.z, -1e-5f);  // tangent y, bitangent z
}

TEST(VertexFigures, AreTheDrawnNumbersOfTheVertex) {
    const SyntheticAsset synthetic;
    const auto shown = std::make_unique<Character>();  // on the stack g++ 12 takes its keys for uninitialised
    Character& character = *shown;
    character.asset = synthetic.asset;
    character.posed.evaluator = std::make_unique<Evaluator>(character.asset);
    character.posed.evaluator->setPose(synthetic.asset.animation.bonesOf(1), synthetic.asset.animation.poseOf(1));
    skinFrame(*character.posed.evaluator, 1, character.posed.vertices);
    evaluateCoefficients(*character.posed.evaluator, 1, character.posed.vertices);
    character.posed.truth_frame.update({});
    character.posed.coefficients.update({});
    Shot shot;
    shot.asset = &character.asset;
    const std::vector<float> e = ambientOf(shot, character.posed.vertices.coefficients, 1);
    const std::vector<std::uint32_t> cluster = clusterOfVertex(character.asset);
    for (std::size_t v = 0; v < e.size(); v += 17) {
        const VertexFigures figures = figuresOf(character, v);
        EXPECT_NEAR(figures.model_ambient, e[v], 1e-6);
        EXPECT_EQ(figures.cluster, cluster[v]);
        EXPECT_TRUE(figures.truth.empty());
        EXPECT_EQ(figures.scores.size(), character.asset.model.clusters[cluster[v]].components());
    }
}

// E is linear in the scores: E of a pose is E of the means plus the scores times the components'. The evaluator
// clamps E to [0, 1], so this asset's E stays inside. The measured error is 2e-7.
TEST(ComponentAmbient, AddsUpToThePosesAmbient) {
    const SyntheticAsset synthetic(player_test::AssetRecipe{.basis_size = 0.01f});
    const AssetView& asset = synthetic.asset;
    Evaluator evaluator(asset);
    FrameVertices vertices;
    evaluator.setPose(asset.animation.bonesOf(1), asset.animation.poseOf(1));
    skinFrame(evaluator, 1, vertices);
    evaluateCoefficients(evaluator, 1, vertices);
    Shot shot;
    shot.asset = &asset;
    const std::vector<float> e = ambientOf(shot, vertices.coefficients, 1);
    std::vector<float> mean;
    for (const ClusterView& cluster : asset.model.clusters) {
        std::vector<float> coefficients(cluster.mean.count);
        decode(cluster.mean, coefficients);
        mean.insert(mean.end(), coefficients.begin(), coefficients.end());
    }
    std::vector<float> sum = ambientOf(shot, mean, 1);
    const std::vector<std::uint32_t> cluster = clusterOfVertex(asset);
    ASSERT_GT(mostComponents(asset.model), 0u);
    for (std::size_t k = 0; k < mostComponents(asset.model); ++k) {
        const std::vector<float> effect = componentAmbient(asset.model, e.size(), k);
        for (std::size_t v = 0; v < e.size(); ++v)
            if (k < evaluator.scores(cluster[v]).size()) sum[v] += evaluator.scores(cluster[v])[k] * effect[v];
    }
    std::size_t inside = 0;
    for (std::size_t v = 0; v < e.size(); ++v) {
        if (e[v] < 1e-3f || e[v] > 0.999f) continue;
        ++inside;
        EXPECT_NEAR(sum[v], e[v], 1e-5);
    }
    EXPECT_GT(inside, e.size() / 4);
}

TEST(DivergingColor, EndsAreBlueAndRed) {
    EXPECT_GT(divergingColor(-1, 1).z, divergingColor(-1, 1).x);
    EXPECT_GT(divergingColor(5, 1).x, divergingColor(5, 1).z);
    EXPECT_EQ(divergingColor(0, 1), divergingColor(3, 0));
}

}  // namespace
}  // namespace penumbra::test_view_pick
