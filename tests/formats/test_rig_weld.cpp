// Tests shading points, influences and names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_weld {
namespace {

using testing::ElementsAre;

SourceVertices vertices(const std::vector<Vec3>& positions, std::vector<float> weights = {}) {
    SourceVertices out;
    out.positions = positions;
    out.influences = 2;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const float w = weights.empty() ? 1.f : weights[v];
        out.joints.insert(out.joints.end(), {0, 1});
        out.weights.insert(out.weights.end(), {w, 1 - w});
    }
    return out;
}

TEST(RigWeld, SamePlaceAndWeightsIsOnePoint) {
    Mesh mesh;
    Skin skin;
    SourceVertices source = vertices({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-0.f, 0, 0}}, {1, .5f, 1, .75f, 1});
    weldVertices(source, {}, mesh, skin);
    EXPECT_THAT(mesh.source_vertex, ElementsAre(0, 1, 0, 2, 0));
    EXPECT_THAT(skin.weights, ElementsAre(1, 0, .5f, .5f, .75f, .25f));
}

// Pairs that are half the tolerance apart along a line weld wherever the grid's cells end. Pairs three times as far
// do not.
TEST(RigWeld, ToleranceDoesNotDependOnWhereAPointLies) {
    for (const auto& [gap, expected] : {std::pair(0.5e-6f, 1001u), std::pair(3e-6f, 2001u)}) {
        std::vector<Vec3> positions{{0, 1, 0}};
        for (int i = 0; i < 1000; ++i) {
            const float x = float(i) * 1e-3f * 0.0625f;  // below 1/16: floats are 4e-9 apart
            positions.push_back({x, 0, 0});
            positions.push_back({x + (i % 2 == 0 ? gap : -gap), 0, 0});
        }
        Mesh mesh;
        Skin skin;
        SourceVertices source = vertices(positions);
        weldVertices(source, {}, mesh, skin);
        EXPECT_EQ(mesh.vertexCount(), expected) << gap;
    }
}

// An unused vertex has no influence on the normal of the point that it is given.
TEST(RigWeld, UnusedVerticesTurnNoNormal) {
    SourceVertices source = vertices({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}});
    source.triangles = {{0, 1, 2}};
    source.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0.6f, 0.8f}, {0, 1, 0}};
    Mesh mesh;
    Skin skin;
    const WeldedPoints points = weldVertices(source, {}, mesh, skin);
    ASSERT_EQ(points.rest_normals.size(), 3u);
    EXPECT_LT(length(points.rest_normals[2] - Vec3{0, 0.6f, 0.8f}), 1e-6f);
}

// A vertex that no triangle uses is no point, and gives none its place, even where it is the first of all.
TEST(RigWeld, UnusedVerticesGiveNoPointTheirPlace) {
    SourceVertices source = vertices({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {5, 5, 5}, {0, 1, 0}});
    source.triangles = {{1, 2, 4}};
    Mesh mesh;
    Skin skin;
    weldVertices(source, {}, mesh, skin);
    EXPECT_THAT(mesh.rest_positions, ElementsAre(Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}));
    EXPECT_THAT(mesh.source_vertex, ElementsAre(0, 0, 1, 1, 2));
}

// A place of two parts has a point of each.
TEST(RigWeld, PlaceOfTwoSlotsHasTwoPoints) {
    SourceVertices source = vertices({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}});
    source.slots = {"body/skin", "body/cloth"};
    source.slot_of_vertex = {0, 0, 1, 1};
    Mesh mesh;
    Skin skin;
    weldVertices(source, {}, mesh, skin);
    EXPECT_EQ(mesh.slots, source.slots);
    EXPECT_THAT(mesh.slot_of_vertex, ElementsAre(0, 0, 1, 1));
    EXPECT_THAT(mesh.source_vertex, ElementsAre(0, 1, 2, 3));
}

TEST(RigWeld, TrianglesFollowAndThoseThatCollapseGo) {
    SourceVertices source = vertices({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {2, 0, 0}});
    source.triangles = {{0, 1, 2}, {3, 1, 2}, {0, 3, 1}, {0, 1, 4}};
    Mesh mesh;
    Skin skin;
    weldVertices(source, {}, mesh, skin);
    EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 1, 2}));
}

// One part has 12 influences that come unsorted, not normalised and with a joint named twice.
TEST(RigWeld, KeepsAllInfluencesOfSumOne) {
    RigSource source = samples::skinnedTriangle(12);
    SourcePart& part = source.parts[0];
    part.joints = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 11};
    part.weights = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 20, 0};
    part.positions.resize(1);
    part.triangles.clear();
    const SourceVertices out = gatherVertices(source, chooseJoints(source));
    EXPECT_EQ(out.influences, 10);
    EXPECT_THAT(out.joints, ElementsAre(9, 8, 7, 6, 5, 4, 3, 2, 1, 0));
    for (std::size_t i = 0; i < 10; ++i) EXPECT_FLOAT_EQ(out.weights[i], float(i == 0 ? 30 : 10 - i) / 75);
    for (const double bad : {-1.0, double(NAN), double(INFINITY)}) {
        part.weights[0] = bad;
        EXPECT_THROW(gatherVertices(source, chooseJoints(source)), InvalidInput);
    }
}

// The share of influences beyond 64 that are cut is reported: here 6 of 70 equal weights.
TEST(RigWeld, InfluencesAreCutAtSixtyFourAndThatIsSaid) {
    RigSource source = samples::skinnedTriangle(70);
    EXPECT_EQ(gatherVertices(source, chooseJoints(source)).influences, 64);
    sayInfluences(source);
    ASSERT_EQ(source.notes.size(), 1u);
    EXPECT_EQ(textOf(source.notes[0]),
              "f.glb: node 'n0': 3 vertices with more than 64 influences: the smallest are cut, up to 8.6% of a "
              "vertex's weight");
}

// Vertex 1 has no weights and moves with the root, whose node comes first. A vertex of no triangle is not counted.
TEST(RigWeld, VerticesWithoutWeightsMoveWithTheRoot) {
    RigSource source = samples::skinnedTriangle(2);
    SourcePart& part = source.parts[0];
    source.skins[0].nodes = {1, 0};
    part.positions.push_back({5, 5, 5});
    part.joints.insert(part.joints.end(), {0, 0});
    part.weights = {0, 1, 0, 0, 1, 0, 0, 0};
    const SourceVertices out = gatherVertices(source, chooseJoints(source));
    EXPECT_EQ(out.influences, 1);
    EXPECT_THAT(out.joints, ElementsAre(1, 1, 0, 1));
    sayInfluences(source);
    ASSERT_EQ(source.notes.size(), 1u);
    EXPECT_EQ(textOf(source.notes[0]), "f.glb: node 'n0': 1 vertex without weights: move with 'n0'");
}

// Two nodes of one name are two slots. Parts of one node and material are one.
TEST(RigWeld, SlotsOfEqualNamesAreNumbered) {
    RigSource source;
    source.nodes.resize(3);
    for (Node& node : source.nodes) node.name = "arm";
    source.parts.resize(3);
    source.parts[1].node = source.parts[2].node = 2;
    std::vector<std::string> slots;
    for (const SourcePart& part : source.parts) slotOf(source, part, slots);
    EXPECT_THAT(slots, ElementsAre("arm/default", "arm#2/default"));
}

TEST(RigWeld, SampleKeepsSixInfluences) {
    const Rig rig = samples::readSample("influences8");
    EXPECT_EQ(rig.skin.influences, 6);
    for (std::size_t v = 0; v < rig.mesh.vertexCount(); ++v) {
        const auto row = std::span(rig.skin.weights).subspan(6 * v, 6);
        EXPECT_NEAR(std::accumulate(row.begin(), row.end(), 0.0), 1, 3e-7);
        EXPECT_TRUE(std::is_sorted(row.rbegin(), row.rend()));
    }
}

TEST(RigNames, AreMadeUniqueWithoutTakingOnesThatExist) {
    EXPECT_THAT(uniqueNames({"arm", "arm", "arm#2", "leg", "arm"}),
                ElementsAre("arm", "arm#3", "arm#2", "leg", "arm#4"));
}

TEST(RigMatrix, InverseAndDecompositionUndoComposition) {
    const Quaternion q = *normalized({0.3, -0.2, 0.5, 0.7});
    for (const std::array<double, 3>& scale :
         {std::array{1., 2., 3.}, std::array{-1e-3, 1e-3, 2e-3}, std::array{1e4, 1., 1.}}) {
        const Matrix m = composeTransform({4, -5, 6}, q, scale);
        const Matrix back = multiply(m, inverse(m).value());
        for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(back[i], kIdentityMatrix[i], 1e-12);
        const Decomposition parts = decompose(m);
        EXPECT_TRUE(parts.exact);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(parts.scale[i], scale[i], 1e-12 * std::abs(scale[0]));
        const double sign = parts.rotation[3] * q[3] < 0 ? -1 : 1;
        for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(sign * parts.rotation[i], q[i], 1e-12);
    }
    EXPECT_FALSE(inverse(composeTransform({}, q, {1, 0, 1})).has_value());
    Matrix sheared = kIdentityMatrix;
    sheared[1] = 0.5;
    EXPECT_FALSE(decompose(sheared).exact);
}

// Tests every rotation matrix by half turns, from each of Shepperd's four branches.
TEST(RigMatrix, DecompositionFindsRotationsByHalfTurns) {
    for (const Quaternion& q :
         {Quaternion{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0.7, 0.7, 0.1, 0.05}}) {
        const Quaternion unit = *normalized(q);
        const Quaternion found = decompose(composeTransform({}, unit, {1, 1, 1})).rotation;
        EXPECT_NEAR(length(rotationVector(multiply(conjugate(unit), found))), 0, 1e-7);
    }
}

TEST(RigMatrix, SlerpTurnsEvenlyAndTheShortWay) {
    const Quaternion a{0, 0, 0, 1}, b{0, 0, std::sin(0.6), std::cos(0.6)}, far{0, 0, -b[2], -b[3]};
    for (const double t : {0.0, 0.1, 0.5, 1.0}) {
        EXPECT_NEAR(rotationVector(slerp(a, b, t)).z, 1.2 * t, 1e-12);
        EXPECT_NEAR(rotationVector(slerp(a, far, t)).z, 1.2 * t, 1e-12);
    }
    const Quaternion near{0, 0, 1e-13, 1};
    EXPECT_NEAR(slerp(a, near, 0.5)[2], 0.5e-13, 1e-20);
}

}  // namespace
}  // namespace penumbra::test_rig_weld
