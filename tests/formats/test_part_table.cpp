// Tests how a skinned mesh is divided into parts, on skeletons whose joints own tetrahedra of chosen sizes.
#include <gtest/gtest.h>

#include "formats/common/part_table.h"

namespace penumbra::test_part_table {
namespace {

// A skeleton that owns one tetrahedron for each joint with a size > 0.
struct Rig {
    Mesh mesh;
    Skin skin;

    explicit Rig(const std::vector<std::int32_t>& parents) {
        skin.parents = parents;
        skin.influences = 2;
        for (std::size_t j = 0; j < parents.size(); ++j) skin.joint_names.push_back("j" + std::to_string(j));
    }
    std::uint32_t addVertex(std::uint16_t joint, Vec3 at) {
        mesh.rest_positions.push_back(at);
        skin.joints.insert(skin.joints.end(), {joint, std::uint16_t(0)});
        skin.weights.insert(skin.weights.end(), {0.75f, 0.25f});
        return std::uint32_t(mesh.rest_positions.size() - 1);
    }
    void addBody(std::uint16_t joint, float size) {
        const float x = float(joint);
        const std::uint32_t v = addVertex(joint, {x, 0, 0});
        addVertex(joint, {x + size, 0, 0});
        addVertex(joint, {x, size, 0});
        addVertex(joint, {x, 0, size});
        for (const Triangle t : {Triangle{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
            mesh.triangles.push_back({v + t[0], v + t[1], v + t[2]});
    }
    PartTable table() const { return makePartTable(mesh, skin); }
};

Rig rigOf(const std::vector<std::int32_t>& parents, const std::vector<float>& sizes) {
    Rig rig(parents);
    for (std::size_t j = 0; j < sizes.size(); ++j)
        if (sizes[j] > 0) rig.addBody(std::uint16_t(j), sizes[j]);
    return rig;
}

std::vector<std::int32_t> chainOf(std::int32_t joints) {
    std::vector<std::int32_t> parents;
    for (std::int32_t j = 0; j < joints; ++j) parents.push_back(j - 1);
    return parents;
}

using Indices = std::vector<std::uint16_t>;
using Steps = std::vector<std::uint8_t>;

TEST(PartTable, AChainHasOneStepABone) {
    const PartTable table = rigOf(chainOf(4), {1, 1, 1, 1}).table();
    EXPECT_EQ(table.joint_of_part, (Indices{0, 1, 2, 3}));
    EXPECT_EQ(table.part_of_joint, (Indices{0, 1, 2, 3}));
    EXPECT_EQ(table.steps, (Steps{0, 1, 2, 3, 1, 0, 1, 2, 2, 1, 0, 1, 3, 2, 1, 0}));
    for (std::size_t v = 0; v < 16; ++v) EXPECT_EQ(table.part_of_vertex[v], v / 4);
    for (std::size_t t = 0; t < 16; ++t) EXPECT_EQ(table.part_of_triangle[t], t / 4);
}

// Two arms and a head hang from a chest that owns nothing.
TEST(PartTable, AForkAtAJointWithoutVerticesIsTwoSteps) {
    const PartTable table = rigOf({-1, 0, 0, 0, 1}, {0, 1, 1, 1, 1}).table();
    EXPECT_EQ(table.joint_of_part, (Indices{1, 2, 3, 4}));
    EXPECT_EQ(table.part_of_joint, (Indices{0, 0, 1, 2, 3}));  // the chest has no ancestor with a part
    EXPECT_EQ(table.stepsBetween(0, 1), 2);                    // arm to arm
    EXPECT_EQ(table.stepsBetween(1, 2), 2);
    EXPECT_EQ(table.stepsBetween(0, 3), 1);  // arm to its forearm
    EXPECT_EQ(table.stepsBetween(1, 3), 3);
}

TEST(PartTable, AHelperJointWithoutVerticesIsNoStep) {
    const PartTable table = rigOf(chainOf(5), {1, 0, 0, 1, 0}).table();
    EXPECT_EQ(table.joint_of_part, (Indices{0, 3}));
    EXPECT_EQ(table.part_of_joint, (Indices{0, 0, 0, 1, 1}));
    EXPECT_EQ(table.steps, (Steps{0, 1, 1, 0}));
}

// The diagonal of the whole is 5.4, so that the bound lies at a half diagonal of 0.11. A finger of 0.1 has 0.087 and a
// hand of 0.2 has 0.17.
TEST(PartTable, SmallPartsMergeIntoTheirAncestors) {
    const PartTable table = rigOf({-1, 0, 1, 2, 2}, {1, 1, 0.2f, 0.1f, 1}).table();
    EXPECT_EQ(table.joint_of_part, (Indices{0, 1, 2, 4}));
    EXPECT_EQ(table.part_of_joint, (Indices{0, 1, 2, 2, 3}));
    EXPECT_EQ(table.part_of_vertex[3 * 4], 2);  // the finger is part of the hand
    EXPECT_EQ(table.part_of_triangle[3 * 4], 2);
    EXPECT_EQ(table.stepsBetween(1, 3), 2);
}

// A finger and its tip are too small alone. The box of both is large enough, so the tip merges and the finger stays.
TEST(PartTable, WhatMergedIntoAPartMakesItLarger) {
    Rig rig = rigOf(chainOf(4), {1, 1, 0.07f, 0.07f});
    const PartTable table = rig.table();
    EXPECT_EQ(table.joint_of_part, (Indices{0, 1, 2}));
    EXPECT_EQ(table.part_of_joint, (Indices{0, 1, 2, 2}));
}

TEST(PartTable, MoreThan32PartsMergeTheSmallestFirst) {
    std::vector<std::int32_t> star(41, 0);  // forty bodies around a root
    star[0] = -1;
    std::vector<float> sizes = {20};
    for (int j = 1; j <= 40; ++j) sizes.push_back(float(100 - j));
    const PartTable table = rigOf(star, sizes).table();
    ASSERT_EQ(table.partCount(), kMaxParts);
    for (std::uint16_t j = 0; j <= 31; ++j) EXPECT_EQ(table.part_of_joint[j], j);
    for (std::uint16_t j = 32; j <= 40; ++j) EXPECT_EQ(table.part_of_joint[j], 0) << j;
    EXPECT_EQ(table.part_of_vertex.back(), 0);
    EXPECT_EQ(table.stepsBetween(3, 7), 2);
}

TEST(PartTable, OneBoneIsOnePart) {
    const PartTable table = rigOf({-1}, {1}).table();
    EXPECT_EQ(table.joint_of_part, (Indices{0}));
    EXPECT_EQ(table.steps, (Steps{0}));
    EXPECT_EQ(table.part_of_vertex, Indices(4, 0));
    EXPECT_EQ(table.part_of_triangle, Indices(4, 0));
}

TEST(PartTable, FromOneRootToAnotherThereIsNoWay) {
    const PartTable table = rigOf({-1, 0, -1, 2}, {1, 1, 1, 1}).table();
    EXPECT_EQ(table.partCount(), 4u);
    EXPECT_EQ(table.stepsBetween(0, 1), 1);
    EXPECT_EQ(table.stepsBetween(3, 2), 1);
    for (std::size_t a : {0u, 1u})
        for (std::size_t b : {2u, 3u}) {
            EXPECT_EQ(table.stepsBetween(a, b), 255);
            EXPECT_EQ(table.stepsBetween(b, a), 255);
        }
}

// Legs may hang from a bone of their own, which is no child of the spine, and still bend the belly.
TEST(PartTable, PartsThatShareAnEdgeOfTheMeshAreOneStepApart) {
    Rig rig = rigOf({-1, 0, 1, 2, -1}, {1, 1, 1, 1, 1});
    rig.mesh.triangles.push_back({0, 3 * 4, 3 * 4 + 1});      // joins bones 0 and 3
    rig.mesh.triangles.push_back({1 * 4, 1 * 4 + 1, 4 * 4});  // joins bone 1 and the other root
    const PartTable table = rig.table();
    EXPECT_EQ(table.stepsBetween(0, 3), 1);
    EXPECT_EQ(table.stepsBetween(3, 0), 1);
    EXPECT_EQ(table.stepsBetween(1, 4), 1);
    EXPECT_EQ(table.stepsBetween(4, 1), 1);
    EXPECT_EQ(table.stepsBetween(0, 2), 2);  // the number of steps in the skeleton
    EXPECT_EQ(table.stepsBetween(0, 4), 255);
}

TEST(PartTable, ATriangleBelongsToWhereTwoOfItsCornersDo) {
    Rig rig = rigOf(chainOf(3), {1, 1, 1});
    const std::size_t first = rig.mesh.triangles.size();
    for (const Triangle t : {Triangle{0, 1, 4}, {0, 4, 1}, {4, 0, 1}, {8, 4, 0}}) rig.mesh.triangles.push_back(t);
    const PartTable table = rig.table();
    const Indices found(table.part_of_triangle.begin() + std::ptrdiff_t(first), table.part_of_triangle.end());
    EXPECT_EQ(found, (Indices{0, 0, 0, 2}));  // the last has one corner of each, and goes by its first
}

// A joint may move vertices most of which no triangle is its own.
TEST(PartTable, AJointThatOwnsNoTriangleHasThePartAboveIt) {
    Rig rig = rigOf(chainOf(3), {1, 1, 0});
    const std::uint32_t lone = rig.addVertex(2, {1.5f, 0, 0});
    rig.mesh.triangles.push_back({4, 5, lone});
    const PartTable table = rig.table();
    EXPECT_EQ(table.joint_of_part, (Indices{0, 1}));
    EXPECT_EQ(table.part_of_vertex[lone], 1);
    EXPECT_EQ(table.part_of_triangle.back(), 1);
}

TEST(PartTable, BacksHaveThePartsOfTheirFronts) {
    const Rig rig = rigOf(chainOf(3), {1, 1, 1});
    const PartTable fronts = rig.table(), both = makePartTable(withBacks(rig.mesh), withBacks(rig.skin));
    EXPECT_EQ(both.joint_of_part, fronts.joint_of_part);
    EXPECT_EQ(both.steps, fronts.steps);
    for (std::size_t v = 0; v < both.part_of_vertex.size(); ++v)
        EXPECT_EQ(both.part_of_vertex[v], fronts.part_of_vertex[v % fronts.part_of_vertex.size()]);
    for (std::size_t t = 0; t < both.part_of_triangle.size(); ++t)
        EXPECT_EQ(both.part_of_triangle[t], fronts.part_of_triangle[t % fronts.part_of_triangle.size()]);
}

}  // namespace
}  // namespace penumbra::test_part_table
