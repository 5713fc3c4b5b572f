#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/common/errors.h"
#include "formats/common/surface_tree.h"
#include "tests/formats/round_trip.h"

namespace penumbra::test_drawn_mesh {
namespace {

struct Soup {
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
};

Soup randomSoup(std::uint32_t triangles) {
    std::mt19937 random(5);
    const auto number = [&] { return float(random() / 4294967296.0); };
    Soup soup;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        const Vec3 at{number(), number(), number()};
        for (int i = 0; i < 3; ++i)
            soup.positions.push_back(at + Vec3{number() * 0.2f, number() * 0.2f, number() * 0.2f});
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return soup;
}

// The least distance over a grid of weights is never below that of the weights that are found, and hardly above.
TEST(SurfaceTree, FindsTheNearestPoint) {
    const Soup soup = randomSoup(60);
    const SurfaceTree tree(soup.triangles, soup.positions);
    std::mt19937 random(6);
    for (int trial = 0; trial < 20; ++trial) {
        const Vec3 p{float(random() / 4294967296.0), float(random() / 4294967296.0), float(random() / 4294967296.0)};
        const auto found = tree.nearest(p, [](std::uint32_t, const std::array<double, 3>&) { return 0.0; });
        ASSERT_TRUE(found);
        double least = INFINITY;
        for (const Triangle& t : soup.triangles)
            for (int i = 0; i <= 40; ++i)
                for (int j = 0; i + j <= 40; ++j) {
                    const double u = i / 40.0, v = j / 40.0;
                    const Vec3d q = toDouble(soup.positions[t[0]]) * u + toDouble(soup.positions[t[1]]) * v +
                                    toDouble(soup.positions[t[2]]) * (1 - u - v);
                    least = std::min(least, length(q - toDouble(p)));
                }
        EXPECT_LE(found->distance, least + 1e-12);
        EXPECT_GE(found->distance, least - 0.01);  // half a step of the grid
    }
}

TEST(SurfaceTree, PassesOverWhatDoesNotCount) {
    const Soup soup = randomSoup(9);
    const SurfaceTree tree(soup.triangles, soup.positions);
    const auto only = [](std::uint32_t wanted) {
        return [wanted](std::uint32_t t, const std::array<double, 3>&) { return t == wanted ? 0.0 : double(INFINITY); };
    };
    EXPECT_EQ(tree.nearest({0, 0, 0}, only(7))->triangle, 7u);
    EXPECT_FALSE(tree.nearest({0, 0, 0}, only(9)));
}

// Two squares back to back, a hair apart: a vertex takes the one that looks where it looks.
TEST(NearestPoints, AgreeInTheirNormals) {
    Mesh squares;
    squares.rest_positions = {{0, 0, 0},       {1, 0, 0},       {1, 1, 0},       {0, 1, 0},
                              {0, 0, -0.001f}, {1, 0, -0.001f}, {1, 1, -0.001f}, {0, 1, -0.001f}};
    squares.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    std::vector<Vec3> normals(8, {0, 0, 1});
    for (std::size_t v = 4; v < 8; ++v) normals[v] = {0, 0, -1};
    Mesh drawn;
    drawn.rest_positions = {{0.25f, 0.5f, 0}, {0.25f, 0.5f, 0}, {0.25f, 0.5f, 0}};
    const std::vector<Vec3> looks{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
    PointDistances distances;
    const PointTable points = nearestPoints({squares, normals}, {drawn, looks}, nullptr, 1, distances);
    EXPECT_EQ(points.corners[0], (Triangle{0, 2, 3}));
    EXPECT_EQ(points.corners[1], (Triangle{4, 7, 6}));
    EXPECT_EQ(distances.distance[0], 0.0f);
    EXPECT_NEAR(distances.distance[1], 0.001f, 1e-7f);
    EXPECT_TRUE(std::isinf(distances.distance[2]));  // upright on both
}

TEST(DrawnMesh, IsKeptByVisibilityFiles) {
    const VisibilityHeader header = samples::pointsHeader(2);
    const samples::Folder folder("points");
    samples::writeVisibility(folder.path / "a", header, Precision::kFloat32);
    const VisibilityReader reader(folder.path / "a");
    ASSERT_TRUE(reader.header().drawn);
    const DrawnMesh& drawn = *reader.header().drawn;
    EXPECT_EQ(drawn.points, header.drawn->points);
    EXPECT_EQ(drawn.vertex_of_point, header.drawn->vertex_of_point);
    EXPECT_EQ(drawn.mesh.triangles, header.drawn->mesh.triangles);
    EXPECT_EQ(drawn.mesh.slots, header.mesh.slots);
    EXPECT_EQ(drawn.mesh.slot_of_vertex, header.drawn->mesh.slot_of_vertex);
    EXPECT_EQ(drawn.skin.joints, header.drawn->skin.joints);
    EXPECT_EQ(drawn.skin.weights, header.drawn->skin.weights);
    EXPECT_EQ(drawn.mesh.morphs, header.drawn->mesh.morphs);
    EXPECT_EQ(drawn.mesh.opacity, header.drawn->mesh.opacity);
}

TEST(DrawnMesh, IsKeptByModelFiles) {
    Model model = samples::model(FeatureKind::kRelativeBones);
    DrawnMesh drawn{model.mesh, model.skin, model.rest_normals, {}, {}};
    for (std::uint32_t v = 0; v < model.mesh.vertexCount(); ++v) {
        drawn.points.corners.push_back({v, v, v});
        drawn.points.weights.push_back({1, 0, 0});
        drawn.vertex_of_point.push_back(v);
    }
    model.drawn = drawn;
    const Model back = samples::roundTrip(
        model, [](const auto& path, const Model& written) { writeModel(path, written); },
        [](const auto& path) { return readModel(path); });
    ASSERT_TRUE(back.drawn);
    EXPECT_EQ(back.drawn->points, drawn.points);
}

TEST(DrawnMesh, RefusesTablesThatDoNotFit) {
    const samples::Folder folder("points");
    const auto expectRefusal = [&](const VisibilityHeader& header, const std::string& field) {
        samples::writeVisibility(folder.path / "a", header, Precision::kFloat32);
        try {
            const VisibilityReader reader(folder.path / "a");
            ADD_FAILURE() << field;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
        }
    };
    VisibilityHeader header = samples::pointsHeader(1);
    header.drawn->points.corners[2][1] = 4;
    expectRefusal(header, "/drawn/point_corners");
    header = samples::pointsHeader(1);
    header.drawn->points.weights[3] = {0.5f, 0.25f, 0};
    expectRefusal(header, "/drawn/point_weights");
    header = samples::pointsHeader(1);
    header.drawn->points.weights[3] = {1.5f, -0.5f, 0};
    expectRefusal(header, "/drawn/point_weights");
    header = samples::pointsHeader(1);
    header.drawn->vertex_of_point[1] = 2;
    expectRefusal(header, "/drawn/vertex_of_point");
    header = samples::pointsHeader(1);
    header.drawn->mesh.triangles[0][0] = 6;
    expectRefusal(header, "/drawn/triangles");
    header = samples::pointsHeader(1);
    header.drawn->mesh.morphs.vertices[1] = 6;
    expectRefusal(header, "/drawn/morphs/vertices");
    header = samples::pointsHeader(1);
    header.drawn->mesh.morphs.names = {"frown"};
    expectRefusal(header, "/drawn/morphs/names");
    header = samples::pointsHeader(1);
    header.drawn->mesh.opacity.triangles[1] = 4;
    expectRefusal(header, "/drawn/opacity_triangles");
}

}  // namespace
}  // namespace penumbra::test_drawn_mesh
