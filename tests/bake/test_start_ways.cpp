// Tests where the rays of the points of a hard edge start.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bake/trace/blockers.h"
#include "bake/trace/moments.h"
#include "bake/trace/start_ways.h"
#include "bake/trace/vertex_side.h"
#include "formats/common/mesh_places.h"

namespace penumbra::test_start_ways {
namespace {

TEST(StartWays, LieBetweenTheSidesOfAPlace) {
    const std::vector<Vec3> normals{{0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
    const float s = float(std::sqrt(0.5));
    const std::vector<Vec3> ways = startWays(std::vector<std::uint32_t>{0, 0, 2, 2, 4}, normals);
    EXPECT_LT(length(ways[0] - Vec3{s, s, 0}), 1e-6);
    EXPECT_LT(length(ways[1] - Vec3{s, s, 0}), 1e-6);
    for (const std::size_t v : {2, 3, 4}) EXPECT_EQ(ways[v], normals[v]);  // two layers of a sheet, and a lone point
}

// In the inner corner of three faces each normal lies in the planes of the two others.
TEST(DirectionToSide, LeadsOutOfCornersOfThreeFaces) {
    const std::vector<Vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
    const Vec3 way = directionToSide(makeFans(triangles, 4), positions, 0, {0, 0, 1}, 1);
    for (const float c : {way.x, way.y, way.z}) EXPECT_GT(c, 0.3f);
}

// A floor and a wall that meet in an inner edge, of which each side sees half of its sky. Rays that started in the
// plane of the other side would see through it.
TEST(StartWays, InnerEdgesDoNotLeak) {
    const std::vector<Vec3> positions{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0},
                                      {0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    const std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    std::vector<Vec3> normals(8, Vec3{0, 1, 0});
    std::fill(normals.begin() + 4, normals.end(), Vec3{1, 0, 0});
    const std::vector<std::uint32_t> first = firstOfPlaces(positions, {});
    EXPECT_EQ(first, (std::vector<std::uint32_t>{0, 1, 2, 3, 0, 5, 6, 1}));
    // The points are in the middle of the edge, as the ends see past both sides.
    const std::vector<Vec3> points(2, Vec3{0, 0, 0.5f}), of_points{normals[0], normals[4]};
    const std::vector<Vec3> ways = startWays(std::vector<std::uint32_t>{0, 0}, of_points);
    const SceneScale scale = sceneScale(positions, boxDiagonal(positions));
    std::vector<Vec3> scaled;
    for (const Vec3 p : positions) scaled.push_back(scale.apply(p));
    const OcclusionScene scene(scaled, triangles);
    const RayDirections directions = makeRayDirections(1024, 1, 2);
    std::vector<float> b(8);
    MomentTracer tracer{scene, directions, scale};
    tracer.start_ways = ways;
    traceMoments(tracer, points, of_points, {b});
    for (std::size_t p = 0; p < 2; ++p) {
        const Vec3 n = of_points[p];
        const double y = std::sqrt(3 / (4 * std::numbers::pi));
        const double e = (-n.y * b[4 * p + 1] + n.z * b[4 * p + 2] - n.x * b[4 * p + 3]) / (std::numbers::pi * y);
        EXPECT_NEAR(e, 0.5, 0.01) << p;  // at its foot the wall hides half of the sky, as one without end
    }
}

// A tetrahedron whose faces have vertices of their own is one closed surface for the rules of sheets.
TEST(StartWays, HardEdgesAreNoBorders) {
    const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
    for (const Triangle& t : {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 3, 2}, Triangle{1, 2, 3}}) {
        const auto at = std::uint32_t(positions.size());
        for (const std::uint32_t v : t) positions.push_back(corners[v]);
        triangles.push_back({at, at + 1, at + 2});
    }
    Blockers apart, joined;
    apart.add(triangles, positions);
    joined.add(triangles, positions, firstOfPlaces(positions, {}));
    EXPECT_EQ(apart.solids, 0);
    EXPECT_EQ(joined.solids, 1);
    for (const std::int32_t solid : joined.solid_of_vertex) EXPECT_EQ(solid, 1);
}

}  // namespace
}  // namespace penumbra::test_start_ways
