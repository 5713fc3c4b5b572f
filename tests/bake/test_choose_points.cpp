#include <gtest/gtest.h>

#include <cmath>

#include "bake/source/choose_points.h"
#include "tests/bake/shapes.h"

namespace penumbra::test_choose_points {
namespace {

Mesh meshOf(const shapes::Shape& shape) {
    Mesh mesh;
    mesh.rest_positions = shape.positions;
    mesh.triangles = shape.triangles;
    for (std::uint32_t v = 0; v < shape.positions.size(); ++v) mesh.source_vertex.push_back(v);
    return mesh;
}

double areaOf(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
    double area = 0;
    for (const Triangle& t : triangles)
        area += double(length(cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]))) / 2;
    return area;
}

// A closed surface of genus 0 has 2 V - 4 triangles. Those of 300 points lie inside of the sphere, so their area is a
// little less than its own; 4% leave room for triangles of unequal size.
TEST(ChoosePoints, LeavesAClosedSurface) {
    const Mesh mesh = meshOf(shapes::sphere({1, 2, 3}, 1, 42));
    const ChosenPoints chosen = choosePoints(mesh, 300);
    ASSERT_EQ(chosen.vertices.size(), 300u);
    EXPECT_EQ(chosen.triangles.size(), 2 * 300u - 4);
    std::vector<Vec3> positions;
    for (const std::uint32_t v : chosen.vertices) positions.push_back(mesh.rest_positions[v]);
    EXPECT_NEAR(areaOf(positions, chosen.triangles) / (4 * std::numbers::pi), 1, 0.04);
    const ChosenPoints again = choosePoints(mesh, 300);
    EXPECT_EQ(again.vertices, chosen.vertices);
    EXPECT_EQ(again.triangles, chosen.triangles);
}

// A flat square bends nowhere: its boundary stays, and points are spread over it. In a square pattern of 60 points no
// place is farther than 0.1 from one.
TEST(ChoosePoints, SpreadsOverFlatPartsAndKeepsTheBoundary) {
    shapes::Shape square;
    constexpr std::uint32_t kSide = 41;
    for (std::uint32_t y = 0; y < kSide; ++y)
        for (std::uint32_t x = 0; x < kSide; ++x) square.positions.push_back({float(x) / 40, float(y) / 40, 0});
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
        for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
            const std::uint32_t v = y * kSide + x;
            square.triangles.push_back({v, v + 1, v + kSide});
            square.triangles.push_back({v + 1, v + kSide + 1, v + kSide});
        }
    const Mesh mesh = meshOf(square);
    const ChosenPoints chosen = choosePoints(mesh, 60);
    ASSERT_EQ(chosen.vertices.size(), 60u);
    std::vector<Vec3> positions;
    for (const std::uint32_t v : chosen.vertices) positions.push_back(mesh.rest_positions[v]);
    EXPECT_NEAR(areaOf(positions, chosen.triangles), 1, 1e-5);
    for (const Vec3 p : mesh.rest_positions) {
        float nearest = 9;
        for (const Vec3 q : positions) nearest = std::min(nearest, length(p - q));
        EXPECT_LT(nearest, 0.25f);
    }
}

// A roof whose ridge is a hard edge has two rows of vertices there. The vertices of each side take points of theirs.
TEST(ChoosePoints, VerticesInterpolateWithinHardEdges) {
    VisibilityHeader header;
    DrawnMesh drawn;
    constexpr std::uint32_t kSide = 21;
    for (std::uint32_t side = 0; side < 2; ++side)
        for (std::uint32_t y = 0; y < kSide; ++y)
            for (std::uint32_t x = 0; x < kSide; ++x) {
                const float away = float(x) / 20;
                drawn.mesh.rest_positions.push_back({side == 0 ? -away : away, -away, float(y) / 20});
                drawn.rest_normals.push_back(normalized(Vec3{side == 0 ? -1.f : 1.f, 1, 0}));
                drawn.mesh.source_vertex.push_back(std::uint32_t(drawn.mesh.source_vertex.size()));
                drawn.skin.joints.push_back(0);
                drawn.skin.weights.push_back(1);
                if (x == 0 || y == 0) continue;
                const auto v = std::uint32_t(drawn.mesh.rest_positions.size() - 1);
                const Triangle a{v - kSide - 1, v - 1, v}, b{v - kSide - 1, v, v - kSide};
                for (const Triangle& t : {a, b})
                    drawn.mesh.triangles.push_back(side == 0 ? Triangle{t[0], t[2], t[1]} : t);
            }
    drawn.skin.joint_names = {"root"};
    drawn.skin.parents = {-1};
    drawn.skin.influences = 1;
    header.drawn = drawn;
    takePoints(choosePoints(drawn.mesh, 60), header);
    ASSERT_EQ(header.mesh.vertexCount(), 60u);
    for (std::size_t v = 0; v < drawn.mesh.vertexCount(); ++v) {
        Vec3 sum;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t corner = header.drawn->points.corners[v][i];
            EXPECT_GT(dot(header.rest_normals[corner], drawn.rest_normals[v]), 0.9f);
            sum += header.mesh.rest_positions[corner] * header.drawn->points.weights[v][i];
        }
        EXPECT_LT(length(sum - drawn.mesh.rest_positions[v]), 1e-5f);
    }
    for (std::size_t p = 0; p < 60; ++p)
        EXPECT_EQ(header.mesh.rest_positions[p], drawn.mesh.rest_positions[header.drawn->vertex_of_point[p]]);
}

// A square of two slots has two rows of vertices where they meet, which look the same way. Both take the same points.
TEST(ChoosePoints, GoOnFromSlotToSlot) {
    VisibilityHeader header;
    DrawnMesh drawn;
    drawn.mesh.slots = {"body/skin", "body/cloth"};
    constexpr std::uint32_t kSide = 21;
    for (std::uint16_t slot = 0; slot < 2; ++slot)
        for (std::uint32_t y = 0; y < kSide; ++y)
            for (std::uint32_t x = 0; x < kSide; ++x) {
                drawn.mesh.rest_positions.push_back({float(slot) + float(x) / 20, float(y) / 20, 0});
                drawn.rest_normals.push_back({0, 0, 1});
                drawn.mesh.slot_of_vertex.push_back(slot);
                drawn.mesh.source_vertex.push_back(std::uint32_t(drawn.mesh.source_vertex.size()));
                drawn.skin.joints.push_back(0);
                drawn.skin.weights.push_back(1);
                if (x == 0 || y == 0) continue;
                const auto v = std::uint32_t(drawn.mesh.rest_positions.size() - 1);
                drawn.mesh.triangles.push_back({v - kSide - 1, v - kSide, v});
                drawn.mesh.triangles.push_back({v - kSide - 1, v, v - 1});
            }
    drawn.skin.joint_names = {"root"};
    drawn.skin.parents = {-1};
    drawn.skin.influences = 1;
    header.drawn = drawn;
    Mesh joined = drawn.mesh;
    joined.triangles = trianglesAcrossSlots(drawn);
    takePoints(choosePoints(joined, 40), header);
    ASSERT_EQ(header.mesh.vertexCount(), 40u);
    for (std::uint32_t y = 0; y < kSide; ++y) {
        const std::size_t a = y * kSide + kSide - 1, b = std::size_t(kSide) * kSide + y * kSide;
        ASSERT_EQ(drawn.mesh.rest_positions[a], drawn.mesh.rest_positions[b]);
        EXPECT_EQ(header.drawn->points.corners[a], header.drawn->points.corners[b]);
        EXPECT_EQ(header.drawn->points.weights[a], header.drawn->points.weights[b]);
    }
}

}  // namespace
}  // namespace penumbra::test_choose_points
