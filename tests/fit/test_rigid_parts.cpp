#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "fit/clusters/rigid_parts.h"
#include "tests/fit/hinged_sheet.h"

namespace penumbra::test_rigid_parts {
namespace {

using synthetic::HingedSheet;
using synthetic::hingedSheet;

RigidParts partsOf(const HingedSheet& sheet, std::size_t count, int threads) {
    std::vector<std::size_t> frames(sheet.frames);
    std::iota(frames.begin(), frames.end(), 0);
    return findRigidParts({sheet.mesh.triangles, sheet.mesh.rest_positions, sheet.positions, frames}, count, threads);
}

double pairs(double n) { return n * (n - 1) / 2; }

// Returns the index of Hubert and Arabie 1985: 1 for the same partition, 0 on average for unrelated ones.
double adjustedRandIndex(const std::vector<std::uint16_t>& a, const std::vector<std::uint16_t>& b) {
    std::map<std::pair<int, int>, double> both;
    std::map<int, double> of_a, of_b;
    for (std::size_t i = 0; i < a.size(); ++i) ++both[{a[i], b[i]}], ++of_a[a[i]], ++of_b[b[i]];
    double same = 0, in_a = 0, in_b = 0;
    for (const auto& [key, n] : both) same += pairs(n);
    for (const auto& [key, n] : of_a) in_a += pairs(n);
    for (const auto& [key, n] : of_b) in_b += pairs(n);
    const double expected = in_a * in_b / pairs(double(a.size()));
    return (same - expected) / ((in_a + in_b) / 2 - expected);
}

TEST(RigidParts, FindTheStripsOfAHingedSheet) {
    const HingedSheet sheet = hingedSheet(60, 0);
    const RigidParts parts = partsOf(sheet, 0, 2);
    EXPECT_EQ(parts.count, 4u);  // strips 0 and 2 move alike but do not touch; rigid strips are not cut
    EXPECT_EQ(adjustedRandIndex(parts.part_of_triangle, sheet.strip_of_triangle), 1);
}

// Noise of 5% of an edge turns a triangle by 0.06 radians at random.
TEST(RigidParts, FindTheStripsUnderNoise) {
    for (double noise : {0.01, 0.05}) {
        const HingedSheet sheet = hingedSheet(60, noise);
        EXPECT_GE(adjustedRandIndex(partsOf(sheet, 0, 2).part_of_triangle, sheet.strip_of_triangle), 0.9) << noise;
    }
}

TEST(RigidParts, SameForAnyThreadCount) {
    const HingedSheet sheet = hingedSheet(60, 0.05);
    const RigidParts one = partsOf(sheet, 12, 1);
    for (int threads : {2, 8}) {
        const RigidParts more = partsOf(sheet, 12, threads);
        EXPECT_EQ(more.part_of_vertex, one.part_of_vertex);
        EXPECT_EQ(more.part_of_triangle, one.part_of_triangle);
    }
}

// When a number is asked for, neighbours that move alike become one, and the strip that bends most is cut.
TEST(RigidParts, TakeTheAskedNumber) {
    const HingedSheet sheet = hingedSheet(60, 0.01);
    for (std::size_t count : {1, 2, 3, 4, 7, 40}) {
        const RigidParts parts = partsOf(sheet, count, 2);
        EXPECT_EQ(parts.count, count);
        std::vector<int> vertices(parts.count);
        for (std::uint16_t part : parts.part_of_vertex) ++vertices[part];
        for (int n : vertices) EXPECT_GT(n, 0) << count;
    }
}

// Strips that lie apart in space are different parts, though nothing moves.
TEST(RigidParts, WhatDoesNotTouchIsApart) {
    HingedSheet sheet = hingedSheet(1, 0);
    std::erase_if(sheet.mesh.triangles, [](const Triangle& t) { return t[0] % 37 == 20; });
    sheet.positions = sheet.mesh.rest_positions;
    const RigidParts parts = partsOf(sheet, 0, 1);
    EXPECT_EQ(parts.count, 2u);
    EXPECT_NE(parts.part_of_vertex[0], parts.part_of_vertex[36]);
    EXPECT_EQ(parts.part_of_vertex[0], parts.part_of_vertex[37 * 22]);
}

TEST(RigidParts, MeshesWithoutAreaOrTrianglesAreOnePart) {
    HingedSheet sheet = hingedSheet(3, 0);
    for (Vec3& p : sheet.mesh.rest_positions) p = {};
    EXPECT_EQ(partsOf(sheet, 0, 1).count, 1u);
    sheet.mesh.triangles.clear();
    EXPECT_EQ(partsOf(sheet, 0, 1).count, 1u);
}

}  // namespace
}  // namespace penumbra::test_rigid_parts
