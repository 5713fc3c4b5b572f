// Tests the sides of thin surfaces: layers of the file, backs of double-sided materials, and vertices of two slots.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/common/mesh_places.h"
#include "formats/common/twin_triangles.h"
#include "formats/rig/rig_build.h"

namespace penumbra::test_rig_sides {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;

// A rig of one joint with these parts, whose triangles are quads of a grid of vertices.
struct PartOf {
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
    bool double_sided = false;
    std::string material = "paint";
};

Rig rigOf(const std::vector<PartOf>& parts, RigSides sides = RigSides::kOfMaterials) {
    RigSource source;
    source.file = "f.glb";
    source.nodes.emplace_back().name = "n";
    for (const PartOf& from : parts) {
        SourcePart& part = source.parts.emplace_back();
        part.material = from.material;
        part.positions = from.positions;
        part.triangles = from.triangles;
        part.color.material.double_sided = from.double_sided;
    }
    std::vector<RigSource> sources;
    sources.push_back(std::move(source));
    RigOptions options;
    options.sides = sides;
    return joinRig(std::move(sources), options);
}

const std::vector<Vec3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
const std::vector<Triangle> kFront{{0, 1, 2}, {0, 2, 3}}, kBack{{0, 2, 1}, {0, 3, 2}};

void expectTwoLayers(const Rig& rig) {
    ASSERT_EQ(rig.mesh.vertexCount(), 8u);
    ASSERT_EQ(rig.mesh.triangles.size(), 4u);
    std::size_t front = 0, back = 0;
    for (const Vec3 n : rig.rest_normals) front += n.z > 0.99f, back += n.z < -0.99f;
    EXPECT_EQ(front, 4u);
    EXPECT_EQ(back, 4u);
    const std::vector<std::uint32_t> twins = twinTriangles(rig.mesh, rig.skin);
    for (std::uint32_t t = 0; t < 4; ++t) {
        EXPECT_NE(twins.at(t), t);
        EXPECT_EQ(twins.at(twins.at(t)), t);
    }
    const std::vector<std::uint32_t> other = twinVertices(rig.mesh, twins);
    for (std::uint32_t v = 0; v < 8; ++v) {
        EXPECT_NE(other[v], v);
        EXPECT_EQ(rig.mesh.rest_positions[other[v]], rig.mesh.rest_positions[v]);
        EXPECT_EQ(rig.rest_normals[other[v]], -rig.rest_normals[v]);
    }
    ASSERT_EQ(rig.source_corners.size(), 4u);
}

// A coat: a tube that is open at both ends and along a slit of 2 degrees has one rim, and is no hidden inside.
TEST(RigSides, SlitTubesHaveBacks) {
    PartOf coat;
    constexpr std::uint32_t kAround = 24;
    for (std::uint32_t i = 0; i <= kAround; ++i)
        for (const float y : {0.0f, 2.0f}) {
            const float turn = 6.2482787f * float(i) / float(kAround);  // 358 degrees
            coat.positions.push_back({std::cos(turn), y, std::sin(turn)});
        }
    for (std::uint32_t i = 0; i < kAround; ++i) {
        coat.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
        coat.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
    }
    coat.double_sided = true;
    EXPECT_EQ(rigOf({coat}).mesh.triangles.size(), 2 * coat.triangles.size());
}

TEST(RigSides, LayersWithVerticesOfTheirOwnStayApart) {
    std::vector<Vec3> positions = kSquare;
    positions.insert(positions.end(), kSquare.begin(), kSquare.end());
    std::vector<Triangle> triangles = kFront;
    for (const Triangle& t : kBack) triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
    const Rig rig = rigOf({{positions, triangles}});
    expectTwoLayers(rig);
    EXPECT_THAT(rig.mesh.source_vertex, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

TEST(RigSides, LayersOfTheSameVerticesAreParted) {
    std::vector<Triangle> triangles = kFront;
    triangles.insert(triangles.end(), kBack.begin(), kBack.end());
    const Rig rig = rigOf({{kSquare, triangles}});
    expectTwoLayers(rig);
    EXPECT_THAT(rig.mesh.source_vertex, ElementsAre(0, 1, 2, 3));  // the file's vertices lead to fronts
    for (const Triangle& corners : rig.source_corners)
        for (const std::uint32_t corner : corners) EXPECT_LT(corner, 4u);
}

TEST(RigSides, OpenDoubleSidedSurfaceGetsBacks) {
    expectTwoLayers(rigOf({{kSquare, kFront, true}}));
    EXPECT_EQ(rigOf({{kSquare, kFront, false}}).mesh.vertexCount(), 4u);
    EXPECT_EQ(rigOf({{kSquare, kFront, true}}, RigSides::kFronts).mesh.vertexCount(), 4u);
}

// A box, of which the top can be as open as `hole` says: 1 has no top, and 0 is closed.
PartOf boxOf(float hole) {
    PartOf out{{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}}, {}, true};
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        out.triangles.push_back({a, b, c});
        out.triangles.push_back({a, c, d});
    };
    quad(0, 1, 2, 3);
    for (std::uint32_t k = 0; k < 4; ++k) quad(k, k + 4, (k + 1) % 4 + 4, (k + 1) % 4);
    if (hole == 0) quad(4, 7, 6, 5);
    if (hole == 0 || hole == 1) return out;
    for (std::uint32_t k = 0; k < 4; ++k) {  // a rim around a square hole of side `hole`
        const Vec3 corner = out.positions[k + 4], middle{0.5f, 1, 0.5f};
        out.positions.push_back(middle + (corner - middle) * hole);
    }
    for (std::uint32_t k = 0; k < 4; ++k) quad(k + 4, k + 8, (k + 1) % 4 + 8, (k + 1) % 4 + 4);
    return out;
}

// The inside of a box with a hole of .09 of its surface can be seen; that of one with .0014 cannot.
TEST(RigSides, ClosedDoubleSidedSurfacesGetNone) {
    EXPECT_EQ(rigOf({boxOf(0)}).mesh.vertexCount(), 8u);
    EXPECT_EQ(rigOf({boxOf(0.09f)}).mesh.vertexCount(), 12u);
    EXPECT_EQ(rigOf({boxOf(0.7f)}).mesh.vertexCount(), 24u);
    EXPECT_EQ(rigOf({boxOf(1)}).mesh.vertexCount(), 16u);
}

TEST(RigSides, OnlyDoubleSidedPartsGetBacks) {
    PartOf far = boxOf(1);
    far.double_sided = false;
    for (Vec3& p : far.positions) p = p + Vec3{5, 0, 0};
    const Rig rig = rigOf({{kSquare, kFront, true}, far});
    EXPECT_EQ(rig.mesh.vertexCount(), 8u + 8u);
    EXPECT_EQ(rig.mesh.slot_of_vertex.size(), rig.mesh.vertexCount());
    EXPECT_EQ(rig.rest_normals.size(), rig.mesh.vertexCount());
}

// Both parts have all vertices of a pool, as exporters of avatars write them, and use the half of them.
TEST(RigSides, SlotsAreThoseOfTheTrianglesThatUseAVertex) {
    std::vector<Vec3> pool = kSquare;
    for (const Vec3 p : kSquare) pool.push_back(p + Vec3{5, 0, 0});
    std::vector<Triangle> right = kFront;
    for (Triangle& t : right)
        for (std::uint32_t& corner : t) corner += 4;
    const Rig rig = rigOf({{pool, kFront, false, "skin"}, {pool, right, false, "cloth"}});
    ASSERT_THAT(rig.mesh.slots, ElementsAre("n/skin", "n/cloth"));
    EXPECT_THAT(rig.mesh.slot_of_vertex, ElementsAre(0, 0, 0, 0, 1, 1, 1, 1));
    EXPECT_THAT(rig.mesh.source_vertex, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7));
}

// Two slots meet at an edge, whose two vertices become two points each. Normals there are smooth all the same.
TEST(RigSides, VertexOfTwoSlotsBecomesTwo) {
    std::vector<Vec3> bent = kSquare;
    bent[3].z = 0.5f;
    const Rig rig = rigOf({{bent, {kFront[0]}, false, "skin"}, {bent, {kFront[1]}, false, "cloth"}});
    ASSERT_EQ(rig.mesh.vertexCount(), 6u);
    std::size_t pairs = 0;
    for (std::uint32_t a = 0; a < 6; ++a)
        for (std::uint32_t b = 0; b < a; ++b)
            if (rig.mesh.rest_positions[a] == rig.mesh.rest_positions[b]) {
                EXPECT_EQ(rig.rest_normals[a], rig.rest_normals[b]);
                EXPECT_NE(rig.mesh.slot_of_vertex[a], rig.mesh.slot_of_vertex[b]);
                ++pairs;
            }
    EXPECT_EQ(pairs, 2u);
}

// Backs move with their fronts, and their normals turn the other way.
TEST(RigSides, BacksHaveTheMorphTargetsOfTheirFronts) {
    Rig rig = rigOf({{kSquare, kFront}});
    rig.part_colors.at(0).color.material.double_sided = true;
    rig.mesh.morphs = {{"bulge"}, {0}, {0, 1}, {2}, {{0, 0, 1}}, {{1, 0, 0}}};
    addBacks(rig);
    ASSERT_EQ(rig.mesh.vertexCount(), 8u);
    const MorphTargets& morphs = rig.mesh.morphs;
    ASSERT_THAT(morphs.vertices, testing::SizeIs(2));
    EXPECT_EQ(rig.mesh.rest_positions[morphs.vertices[1]], rig.mesh.rest_positions[2]);
    EXPECT_THAT(morphs.positions, ElementsAre(Vec3{0, 0, 1}, Vec3{0, 0, 1}));
    EXPECT_THAT(morphs.normals, ElementsAre(Vec3{1, 0, 0}, Vec3{-1, 0, 0}));
}

// Each side of a sheet has places of its own, though the layers have the same positions and skin rows.
TEST(RigSides, SidesOfASheetAreTwoPlaces) {
    const Rig rig = rigOf({{kSquare, kFront, true}});
    EXPECT_THAT(firstOfPlaces(rig.mesh.rest_positions, rig.skin), testing::Each(testing::Lt(4u)));
    EXPECT_THAT(firstOfSides(rig.mesh, rig.skin), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

// A vertex that nothing uses stands before all others, at a place of its own and at one of another slot.
TEST(RigSides, UnusedVerticesGiveNoPointTheirPlaceOrSlot) {
    std::vector<Vec3> pool{{9, 9, 9}};
    pool.insert(pool.end(), kSquare.begin(), kSquare.end());
    std::vector<Triangle> triangles = kFront;
    for (Triangle& t : triangles)
        for (std::uint32_t& corner : t) ++corner;
    const Rig rig = rigOf({{pool, {triangles[0]}, false, "skin"}, {pool, {triangles[1]}, false, "cloth"}});
    EXPECT_THAT(rig.mesh.rest_positions, testing::Not(testing::Contains(Vec3{9, 9, 9})));
    EXPECT_THAT(rig.mesh.slot_of_vertex, ElementsAre(0, 0, 0, 1, 1, 1));
}

}  // namespace
}  // namespace penumbra::test_rig_sides
