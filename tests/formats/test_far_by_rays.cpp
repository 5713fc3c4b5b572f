#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/common/far_by_rays.h"
#include "formats/common/spread_evenly.h"
#include "formats/common/surface_tree.h"
#include "sh/sh_rotation.h"
#include "sh/zonal.h"
#include "tests/bake/shapes.h"
#include "tests/difference.h"

namespace penumbra::test_far_by_rays {
namespace {

using Coefficients = std::array<float, kFieldCoefficients>;

Mesh meshOf(const shapes::Shape& shape) {
    Mesh mesh;
    mesh.triangles = shape.triangles;
    mesh.rest_positions = shape.positions;
    return mesh;
}

// A skin of one joint that moves all.
Skin rigidSkin(std::size_t vertices) {
    Skin skin;
    skin.joint_names = {"all"};
    skin.parents = {-1};
    skin.influences = 1;
    skin.joints.assign(vertices, 0);
    skin.weights.assign(vertices, 1.0f);
    return skin;
}

PartRays raysOf(const Mesh& mesh) {
    const Skin skin = rigidSkin(mesh.vertexCount());
    return {mesh, skin, makePartTable(mesh, skin)};
}

TEST(SurfaceTree, ARayPassesWhatNoTriangleStops) {
    const shapes::Shape shape = shapes::clutter(8);
    const SurfaceTree tree(shape.triangles, shape.positions);
    std::mt19937 random(3);
    const auto number = [&] { return 4 * double(random()) / 4294967296.0 - 2; };
    int passed = 0;
    for (const Vec3d d : fibonacciSphere(2000)) {
        const Vec3 from = toFloat(Vec3d{number(), number(), number()}), way = toFloat(d);
        const bool blocked = shapes::blocked(shapes::seenFrom(toDouble(from), shape), toDouble(way));
        passed += !blocked;
        EXPECT_EQ(tree.passing(from, way, {}), blocked ? 0 : 1);
    }
    EXPECT_GT(passed, 500);
    EXPECT_LT(passed, 1900);
    EXPECT_EQ(SurfaceTree({}, {}).passing({}, {0, 0, 1}, {}), 1);
}

// Rays along the axes have coordinates that are 0.
TEST(SurfaceTree, ARayAlongAnAxisMeetsWhatItShould) {
    const shapes::Shape shape = shapes::square({0, 0, 0}, {0, 0, 1}, 1);
    const SurfaceTree tree(shape.triangles, shape.positions);
    EXPECT_EQ(tree.passing({0.3f, 0.1f, -1}, {0, 0, 1}, {}), 0);
    EXPECT_EQ(tree.passing({0.3f, 0.1f, 1}, {0, 0, 1}, {}), 1);
    EXPECT_EQ(tree.passing({1.3f, 0.1f, -1}, {0, 0, 1}, {}), 1);
    EXPECT_EQ(tree.passing({-2, 0.1f, 0.2f}, {1, 0, 0}, {}), 1);
}

TEST(SurfaceTree, ThinTrianglesLetTheirSharePass) {
    shapes::Shape shape = shapes::square({0, 0, 0}, {0, 0, 1}, 1);
    append(shape, shapes::square({0, 0, 0.5}, {0, 0, 1}, 1));
    const SurfaceTree tree(shape.triangles, shape.positions);
    const Opacity opacity{{0, 1, 2, 3}, {1, 1, 1, 1}, {0, 0, 1, 1}, {51, 102}};  // one stops 20%, the other 40%
    EXPECT_NEAR(tree.passing({0.3f, 0.1f, -1}, {0, 0, 1}, opacity), 0.8 * 0.6, 1e-12);
    const Opacity first{{0, 1}, {1, 1}, {0, 0}, {51}};
    EXPECT_EQ(tree.passing({0.3f, 0.1f, -1}, {0, 0, 1}, first), 0);
}

TEST(PartRays, ABallHasTheClosedFormOfACap) {
    const Vec3d center{2, -1, 3};
    const PartRays rays = raysOf(meshOf(shapes::sphere(center, 0.25, 48)));
    ASSERT_EQ(rays.partCount(), 1u);
    Largest worst;
    for (const Vec3d d : fibonacciSphere(40))
        for (const double r : {1.2, 1.6, 3.0}) {
            std::array<double, kFieldOrder> zonal;
            std::array<double, kFieldCoefficients> lobe;
            capVisibilityZonal(std::asin(1 / r), zonal);
            rotateZonal(zonal, -d, lobe);
            lobe[0] -= std::sqrt(4 * std::numbers::pi);
            Coefficients traced;
            rays.sample(0, toFloat(center + d * (0.25 * r)), traced);
            worst.add(distanceBetween(traced, lobe));
        }
    EXPECT_LT(worst, 0.02f);
    Coefficients inside;
    rays.sample(0, toFloat(center), inside);
    EXPECT_NEAR(inside[0], -std::sqrt(4 * std::numbers::pi), 1e-5);
}

TEST(SpreadEvenly, TakesAllOrSome) {
    EXPECT_EQ(spreadEvenly(3, 5), (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_EQ(spreadEvenly(10, 4), (std::vector<std::size_t>{0, 2, 5, 7}));
    EXPECT_TRUE(spreadEvenly(0, 4).empty());
}

TEST(FieldWarning, NamesThePartAndTheFigure) {
    const std::string text = fieldWarning("chest", 0.2346);
    EXPECT_NE(text.find("'chest'"), std::string::npos);
    EXPECT_NE(text.find("0.235"), std::string::npos);
    EXPECT_NE(text.find("0.1"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test_far_by_rays
