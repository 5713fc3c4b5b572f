#include <gtest/gtest.h>

#include <numbers>

#include "sh/dihedral_angles.h"

namespace penumbra::test_dihedral_angles {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;
constexpr double kPi = std::numbers::pi;

// Two unit triangles that share the z axis, with their fronts up when flat. The left one is turned down by `angle`.
std::vector<Vec3> fold(double angle) {
    return {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, toFloat({-std::cos(angle), -std::sin(angle), 0})};
}
const Triangles kFold{{0, 1, 2}, {3, 1, 0}};

TEST(DihedralAngles, FoldHasItsAngle) {
    const std::vector<InnerEdge> edges = innerEdges(kFold);
    ASSERT_EQ(edges, (std::vector<InnerEdge>{{0, 1, 2, 3}}));
    for (const double angle : {0.0, 1e-4, 0.3, 1.5, 3.1, -1e-4, -0.3, -1.5, -3.1})
        for (const float scale : {1e-4f, 1.0f, 1e4f}) {
            std::vector<Vec3> positions = fold(angle);
            for (Vec3& p : positions) p = p * scale;
            float found = 9;
            dihedralAngles(edges, positions, {&found, 1});
            EXPECT_NEAR(found, angle, 3e-7) << scale;  // positions are float: 6e-8 of 1
        }
}

// A ridge seen from its front is positive, like the fold above with its left side down.
TEST(DihedralAngles, TriangleWithoutAreaIsFlat) {
    std::vector<Vec3> positions = fold(1);
    positions[3] = {0, 0, 0.5};
    float found = 9;
    dihedralAngles(innerEdges(kFold), positions, {&found, 1});
    EXPECT_EQ(found, 0);
}

TEST(DihedralAngles, EdgesAreInnerManifoldOnes) {
    // The order of triangles and of their corners does not matter, nor do triangles with equal corners.
    EXPECT_EQ(innerEdges(Triangles{{1, 0, 3}, {5, 5, 1}, {2, 0, 1}}), (std::vector<InnerEdge>{{0, 1, 2, 3}}));
    EXPECT_TRUE(innerEdges(Triangles{{0, 1, 2}}).empty()) << "boundary";
    EXPECT_TRUE(innerEdges(Triangles{{0, 1, 2}, {0, 1, 3}}).empty()) << "no common front";
    EXPECT_TRUE(innerEdges(Triangles{{0, 1, 2}, {1, 0, 3}, {1, 0, 4}}).empty()) << "three triangles";
    const Triangles tetrahedron{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
    const std::vector<InnerEdge> edges = innerEdges(tetrahedron);
    ASSERT_EQ(edges.size(), 6u);
    for (std::size_t e = 1; e < edges.size(); ++e)
        EXPECT_LT(std::pair(edges[e - 1][0], edges[e - 1][1]), std::pair(edges[e][0], edges[e][1]));
    // In a regular tetrahedron the faces meet at arccos(1/3), and all edges are ridges.
    const std::vector<Vec3> regular{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    std::vector<float> angles(6);
    dihedralAngles(edges, regular, angles);
    for (const float angle : angles) EXPECT_NEAR(std::abs(angle), kPi - std::acos(1.0 / 3), 1e-6);
    for (const float angle : angles) EXPECT_EQ(angle > 0, angles[0] > 0);
}

// A sheet is rolled up by more than two turns. Step by step its angle goes on where a single angle would jump.
TEST(DihedralAngles, TurnsMakeAClipContinuous) {
    const std::vector<InnerEdge> edges = innerEdges(kFold);
    float before = 0;
    for (int step = 0; step <= 300; ++step) {
        const double angle = -15.0 * step / 300;
        float found = 0;
        dihedralAngles(edges, fold(angle), {&found, 1});
        before = addTurns(found, turnsTowards(before, found));
        EXPECT_NEAR(before, angle, 2e-6);
    }
}

}  // namespace
}  // namespace penumbra::test_dihedral_angles
