// Tests which normals shading points have, and where a place has several.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "formats/common/mesh_places.h"
#include "formats/rig/rig_normals.h"
#include "formats/rig/rig_poses.h"
#include "tests/difference.h"
#include "tests/formats/rig_samples.h"

namespace penumbra::test_rig_normals {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kDegree = 3.14159265358979 / 180;

struct Welded {
    Mesh mesh;
    Skin skin;
    WeldedPoints normals;
};
Welded weld(SourceVertices vertices, const RigOptions& options = {}) {
    vertices.influences = 1;
    vertices.joints.assign(vertices.positions.size(), 0);
    vertices.weights.assign(vertices.positions.size(), 1);
    Welded out;
    out.normals = weldVertices(vertices, options, out.mesh, out.skin);
    return out;
}

Vec3 inPlane(double degrees) { return toFloat({std::cos(degrees * kDegree), std::sin(degrees * kDegree), 0}); }

// Vertices at one place with normals in one plane, and a triangle for each that faces along +z, so that no winding
// contradicts them.
Welded weldFan(const std::vector<double>& degrees, double split_angle = 20) {
    SourceVertices v;
    for (const double angle : degrees) {
        const auto first = std::uint32_t(v.positions.size());
        for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, float(angle), 0}, Vec3{1, float(angle) + 1, 0}})
            v.positions.push_back(p);
        v.normals.insert(v.normals.end(), {inPlane(angle), {0, 0, 1}, {0, 0, 1}});
        v.triangles.push_back({first, first + 1, first + 2});
    }
    RigOptions options;
    options.split_angle = split_angle;
    return weld(v, options);
}

// The points at the middle of a fan, in the order of its normals.
std::vector<std::uint32_t> middlePoints(const Welded& fan) {
    std::vector<std::uint32_t> points;
    std::set<std::uint32_t> seen;
    for (std::size_t v = 0; v < fan.mesh.source_vertex.size(); v += 3) points.push_back(fan.mesh.source_vertex[v]);
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t p : points) {
        seen.insert(p);
        numbers.push_back(std::uint32_t(std::distance(seen.begin(), seen.find(p))));
    }
    return numbers;
}

TEST(RigNormals, ThoseWithinTheAngleAreOnePointWithTheirMean) {
    const Welded fan = weldFan({0, 90, 10, 104});
    EXPECT_THAT(middlePoints(fan), ElementsAre(0, 1, 0, 1));
    EXPECT_LT(length(fan.normals.rest_normals[fan.mesh.source_vertex[0]] - inPlane(5)), 1e-6);
    EXPECT_LT(length(fan.normals.rest_normals[fan.mesh.source_vertex[3]] - inPlane(97)), 1e-6);
    EXPECT_THAT(middlePoints(weldFan({0, 90, 10, 104}, 5)), ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(middlePoints(weldFan({0, 90, 10, 104}, 100)), ElementsAre(0, 0, 0, 0));
}

// Steps of 15 degrees all round: each agrees with the next one, but opposite ones must not be one point.
TEST(RigNormals, ChainsDoNotJoinOppositeNormals) {
    for (const double step : {15.0, 5.0, 1.0}) {
        std::vector<double> degrees;
        for (double a = 0; a < 360; a += step) degrees.push_back(a);
        const Welded fan = weldFan(degrees);
        for (std::size_t i = 0; i < degrees.size(); ++i) {
            const Vec3 of_point = fan.normals.rest_normals[fan.mesh.source_vertex[3 * i]];
            EXPECT_GT(dot(of_point, inPlane(degrees[i])), std::cos(30 * kDegree)) << step << ' ' << degrees[i];
        }
    }
}

// A box of six faces, each with four vertices of its own, or of eight vertices.
SourceVertices box(bool shared) {
    SourceVertices v;
    std::vector<Vec3> corners;
    for (int c = 0; c < 8; ++c) corners.push_back({float(c & 1), float(c >> 1 & 1), float(c >> 2 & 1)});
    if (shared) v.positions = corners;
    constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                            {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& face : kFaces) {
        Triangle a{face[0], face[1], face[2]}, b{face[0], face[2], face[3]};
        if (!shared) {
            const auto first = std::uint32_t(v.positions.size());
            for (const std::uint32_t c : face) v.positions.push_back(corners[c]);
            a = {first, first + 1, first + 2};
            b = {first, first + 2, first + 3};
        }
        v.triangles.insert(v.triangles.end(), {a, b});
    }
    return v;
}

Vec3 faceNormal(const Mesh& mesh, const Triangle& t) {
    const Vec3 a = mesh.rest_positions[t[0]];
    return normalized(cross(mesh.rest_positions[t[1]] - a, mesh.rest_positions[t[2]] - a));
}

// Every corner of every triangle has the normal of its face.
void expectHard(const Welded& box) {
    EXPECT_EQ(box.mesh.vertexCount(), 24u);
    for (const Triangle& t : box.mesh.triangles)
        for (const std::uint32_t p : t) EXPECT_LT(length(box.normals.rest_normals[p] - faceNormal(box.mesh, t)), 1e-6);
    const std::vector<std::uint32_t> first = firstOfPlaces(box.mesh.rest_positions, box.skin);
    EXPECT_EQ(std::set<std::uint32_t>(first.begin(), first.end()).size(), 8u);
}

// Lips that touch at rest are two places, because a target opens them.
TEST(MeshPlaces, TargetsPartWhatTouchesAtRest) {
    const std::vector<Vec3> rest(4, Vec3{1, 2, 3});
    const MorphTargets open{.names = {"open", "other"},
                            .rest_weights = {0, 0},
                            .first = {0, 2, 3},
                            .vertices = {1, 3, 2},
                            .positions = {{0, -1, 0}, {0, -1, 0}, {0, -1, 0}},
                            .normals = std::vector<Vec3>(3)};
    EXPECT_THAT(firstOfPlaces(rest, {}), testing::Each(0u));
    EXPECT_THAT(firstOfPlaces(rest, {}, open), testing::ElementsAre(0u, 1u, 2u, 1u));
}

TEST(RigNormals, HardEdgesOfTheFileStayHard) {
    SourceVertices hard = box(false);
    for (std::size_t v = 0; v < 24; ++v) {
        Vec3 n{};
        for (const Triangle& t : hard.triangles)
            if (t[0] / 4 == v / 4)
                n = normalized(
                    cross(hard.positions[t[1]] - hard.positions[t[0]], hard.positions[t[2]] - hard.positions[t[0]]));
        hard.normals.push_back(n);
    }
    expectHard(weld(hard));
    // Normals that are inside out lose to the winding, and the edges stay where they were.
    for (Vec3& n : hard.normals) n = -n;
    const Welded turned = weld(hard);
    expectHard(turned);
    EXPECT_EQ(turned.normals.against_winding.size(), 24u);
}

TEST(RigNormals, CreaseMakesEdgesOnlyWhereItIsAskedFor) {
    EXPECT_EQ(weld(box(false)).mesh.vertexCount(), 8u);
    for (const bool shared : {false, true}) {
        RigOptions options;
        options.crease = 60;
        const Welded hard = weld(box(shared), options);
        expectHard(hard);
        EXPECT_EQ(hard.mesh.source_vertex.size(), shared ? 8u : 24u);
        options.crease = 100;
        EXPECT_EQ(weld(box(shared), options).mesh.vertexCount(), 8u);
    }
}

// Two layers at one place with opposite faces: of vertices of their own or of the same ones, without normals or with
// those of the front for both.
TEST(RigNormals, LayersBackToBackKeepTheirSides) {
    for (const bool shared : {false, true})
        for (const bool with_normals : {false, true}) {
            SourceVertices v;
            for (int layer = 0; layer < (shared ? 1 : 2); ++layer)
                for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}})
                    v.positions.push_back(p);
            const std::uint32_t back = shared ? 0 : 4;
            v.triangles = {{0, 1, 2}, {0, 2, 3}, {back, back + 2, back + 1}, {back, back + 3, back + 2}};
            if (with_normals) v.normals.assign(v.positions.size(), {0, 0, 1});
            const Welded sheet = weld(v);
            EXPECT_EQ(sheet.mesh.vertexCount(), 8u);
            for (const Triangle& t : sheet.mesh.triangles)
                for (const std::uint32_t p : t) EXPECT_EQ(sheet.normals.rest_normals[p], faceNormal(sheet.mesh, t));
        }
}

// A tube whose normals are what the triangles' are: the bits of a rig without NORMAL.
void addNormals(samples::EditableGlb& glb, const std::vector<Vec3>& normals) {
    glb.binary.resize((glb.binary.size() + 3) / 4 * 4, '\0');
    glb.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", normals.size() * 12}});
    glb.binary.append(reinterpret_cast<const char*>(normals.data()), normals.size() * 12);
    glb.json["accessors"].push_back({{"bufferView", glb.json["bufferViews"].size() - 1},
                                     {"componentType", 5126},
                                     {"count", normals.size()},
                                     {"type", "VEC3"}});
    glb.attributes()["NORMAL"] = glb.json["accessors"].size() - 1;
    glb.json["buffers"][0]["byteLength"] = glb.binary.size();
}

Rig readEdited(const samples::EditableGlb& glb, const char* name) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
    samples::writeText(path, glb.bytes());
    return readRig({path});
}

TEST(RigNormals, SmoothFileKeepsItsBytes) {
    const Rig plain = samples::readSample("bend");
    std::vector<Vec3> normals;
    for (const std::uint32_t p : plain.mesh.source_vertex)
        normals.push_back(normalized(plain.rest_normals[p] + Vec3{3e-4f, -3e-4f, 3e-4f}));
    samples::EditableGlb glb = samples::EditableGlb::of("bend");
    addNormals(glb, normals);
    const Rig rig = readEdited(glb, "smooth.glb");
    EXPECT_EQ(rig.rest_normals, plain.rest_normals);
    EXPECT_EQ(rig.mesh.source_vertex, plain.mesh.source_vertex);
    EXPECT_TRUE(rig.notes.empty());
}

// Normals of length 3 that lean by 9 degrees, one of 0 and one that is no number. What is written is read back.
TEST(RigNormals, OfTheFileAreTakenWithLengthOneAndComeBack) {
    const Rig plain = samples::readSample("bend");
    std::vector<Vec3> normals, lean;
    for (const std::uint32_t p : plain.mesh.source_vertex) {
        lean.push_back(normalized(plain.rest_normals[p] + Vec3{0, 0.16f, 0}));
        normals.push_back(lean.back() * 3);
    }
    normals[40] = {0, 0, 0};
    normals[41].y = std::numeric_limits<float>::quiet_NaN();
    samples::EditableGlb glb = samples::EditableGlb::of("bend");
    addNormals(glb, normals);
    const Rig rig = readEdited(glb, "leaning.glb");
    Largest worst;
    for (std::size_t v = 0; v < lean.size(); ++v) {
        const std::uint32_t p = rig.mesh.source_vertex[v];
        worst.add(length(rig.rest_normals[p] - (v == 40 || v == 41 ? plain.rest_normals[p] : lean[v])));
    }
    EXPECT_LT(worst, 1e-6);
    ASSERT_EQ(rig.notes.size(), 1u);
    EXPECT_THAT(textOf(rig.notes[0]), HasSubstr("NORMAL: 2 of "));
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "back.glb";
    writeGlb(path, rig, "");
    EXPECT_EQ(readRig({path}).rest_normals, rig.rest_normals);
}

// The node of a mesh without skin squashes and mirrors: normals go by the inverse transpose, and stay outside.
TEST(RigNormals, FollowTheNodeOfTheirMesh) {
    RigSource source;
    source.file = "box.glb";
    source.nodes.emplace_back().scale = {-1, 4, 1};
    SourcePart part;
    const Vec3 n = normalized(Vec3{1, 1, 0.3f});
    part.positions = {{1, 0, 0}, {0, 1, 0}, {1, 0, 1}};  // the front of it is +x +y
    part.triangles = {{0, 1, 2}};
    part.normals = {n, n, n};
    source.parts.push_back(part);
    std::vector<RigSource> sources;
    sources.push_back(source);
    const Rig rig = joinRig(std::move(sources), {});
    const Vec3 expected = normalized(Vec3{-1, 0.25f, 0.3f});
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, -1, 0).bones, positions, normals);
    for (const Vec3 posed : normals) EXPECT_LT(length(posed - expected), 1e-6);
    EXPECT_TRUE(rig.notes.empty());
}

}  // namespace
}  // namespace penumbra::test_rig_normals
