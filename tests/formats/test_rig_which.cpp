// Which meshes of a file are the character, and how large it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/rest_in_scene.h"
#include "formats/rig/rig_polygon.h"
#include "sh/character_box.h"
#include "tests/formats/glb_writer.h"

namespace penumbra::test_rig_which {
namespace {

using samples::GlbWriter;
using testing::ElementsAre;
using testing::HasSubstr;

shapes::Shape ball(double radius = 0.3, int rings = 8) { return shapes::sphere({}, radius, rings); }

std::vector<Vec3> posedAt(const Rig& rig, int clip, double time, std::vector<Vec3>* normals = nullptr) {
    std::vector<Vec3> positions, out_normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, clip, time).bones, positions, out_normals);
    if (normals) *normals = out_normals;
    return positions;
}

template <class Error>
std::string messageOf(const std::filesystem::path& path, const RigOptions& options) {
    try {
        readRig({path}, options);
    } catch (const Error& error) {
        return error.what();
    }
    return "no such error";
}

// --- Instances, what is hidden, levels of detail --------------------------------------------------------------------

// The third instance is turned by 90 degrees about z and twice as large; the fourth is mirrored.
TEST(RigWhich, InstancesAreCopies) {
    GlbWriter file;
    const shapes::Shape shape = shapes::sphere({0.5, 0, 0}, 0.25, 6);
    const int crowd = file.node("crowd", file.mesh(shape));
    const float half = std::sqrt(0.5f);
    const int translations = file.vectors({{0, 0, 0}, {1, 0, 0}, {0, 5, 0}, {0, 0, 9}});
    const int rotations = file.quaternions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, half, half, 0, 0, 0, 1});
    const int scales = file.vectors({{1, 1, 1}, {1, 1, 1}, {2, 2, 2}, {-1, 1, 1}});
    file.extensionsOf(crowd)["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", translations}, {"ROTATION", rotations}, {"SCALE", scales}};
    const Rig rig = readRig({file.save("instances")});
    const std::size_t n = shape.positions.size();
    ASSERT_EQ(rig.mesh.source_vertex.size(), 4 * n);
    std::vector<Vec3> normals;
    const std::vector<Vec3> positions = posedAt(rig, -1, 0, &normals);
    const Vec3d centers[] = {{0.5, 0, 0}, {1.5, 0, 0}, {0, 6, 0}, {-0.5, 0, 9}};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t v = 0; v < n; ++v) {
            const std::uint32_t point = rig.mesh.source_vertex[i * n + v];
            const Vec3d from_center = toDouble(positions[point]) - centers[i];
            EXPECT_NEAR(length(from_center), i == 2 ? 0.5 : 0.25, 1e-5);
            EXPECT_GT(dot(normalized(from_center), toDouble(normals[point])), 0.9);  // outwards, when mirrored too
        }
    EXPECT_THAT(rig.mesh.slots, ElementsAre("crowd/default"));
}

TEST(RigWhich, WrongInstancesAreRefused) {
    for (const bool other_length : {true, false}) {
        GlbWriter file;
        const int crowd = file.node("crowd", file.mesh(ball()));
        const int two = file.vectors({{0, 0, 0}, {1, 0, 0}}), three = file.vectors({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
        file.extensionsOf(crowd)["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", two},
                                                                             {"SCALE", other_length ? three : 99}};
        EXPECT_THAT(messageOf<InvalidInput>(file.save("wrong_instances"), {}), HasSubstr("node 'crowd'"));
    }
}

TEST(RigWhich, OtherScenesAndIdleCreasesAreSaid) {
    GlbWriter file;
    const shapes::Shape shape = ball();
    const int mesh = file.mesh(shape);
    auto& attributes = file.glb.json["meshes"][std::size_t(mesh)]["primitives"][0]["attributes"];
    std::vector<Vec3> outwards;
    for (const Vec3& p : shape.positions) outwards.push_back(normalized(p));
    attributes["NORMAL"] = file.vectors(outwards);
    file.node("hero", mesh);
    file.node("villain", mesh);
    auto& scenes = file.glb.json["scenes"];
    scenes = {{{"nodes", {0}}}, {{"name", "night"}, {"nodes", {1}}}, {{"name", "same"}, {"nodes", {0}}}};
    RigOptions options;
    options.crease = 30;
    const Rig rig = readRig({file.save("scenes")}, options);
    EXPECT_THAT(rig.mesh.slots, ElementsAre("hero/default"));
    ASSERT_EQ(rig.notes.size(), 2u);
    EXPECT_EQ(rig.notes[0].feature, "scene 'night'");
    EXPECT_EQ(rig.notes[1].feature, "creases");
}

TEST(RigWhich, WhatTheFileHidesIsLeftOutUnlessNamed) {
    GlbWriter file;
    const int mesh = file.mesh(ball());
    const int head = file.node("head", mesh), low = file.node("head_low", mesh), helpers = file.node("helpers");
    file.node("helper", mesh, helpers);
    file.extensionsOf(head)["MSFT_lod"]["ids"] = {low};
    file.extensionsOf(helpers)["KHR_node_visibility"]["visible"] = false;
    const std::filesystem::path path = file.save("hidden");
    EXPECT_THAT(readRig({path}).mesh.slots, ElementsAre("head/default"));
    EXPECT_TRUE(readRig({path}).notes.empty());
    EXPECT_THAT(readRig({path}, {.nodes = {"head*"}}).mesh.slots, ElementsAre("head/default"));
    EXPECT_THAT(readRig({path}, {.nodes = {"head_low"}}).mesh.slots, ElementsAre("head_low/default"));
    EXPECT_THAT(readRig({path}, {.nodes = {"helper"}}).mesh.slots, ElementsAre("helper/default"));
}

// --- --nodes and --without ------------------------------------------------------------------------------------------

TEST(RigWhich, NodesBringTheirSubtreesAndPatternsMustMatch) {
    GlbWriter file;
    const int mesh = file.mesh(ball()), body = file.node("body", mesh);
    file.node("sword_01", mesh, body);
    file.node("floor", mesh);
    file.node("camera rig");
    const std::filesystem::path path = file.save("select");
    const auto slots = [&](const RigOptions& options) { return readRig({path}, options).mesh.slots; };
    EXPECT_THAT(slots({.nodes = {"body"}}), ElementsAre("body/default", "sword_01/default"));
    EXPECT_THAT(slots({.without = {"sword_??", "floor/*"}}), ElementsAre("body/default"));
    EXPECT_THAT(slots({.nodes = {"body", "floor"}, .without = {"body/default"}}),
                ElementsAre("sword_01/default", "floor/default"));
    EXPECT_THAT(messageOf<BadOption>(path, {.nodes = {"flor"}}), HasSubstr("near it are 'floor'"));
    file.node("sword_[0]1", mesh, body);  // a pattern of this name would match sword_01
    EXPECT_THAT(readRig({file.save("select_brackets")}, {.without = {"sword_[0]1", "floor"}}).mesh.slots,
                ElementsAre("body/default", "sword_01/default"));
    EXPECT_THAT(messageOf<BadOption>(path, {.without = {"camera*"}}), HasSubstr("without a mesh at or below it"));
    EXPECT_THAT(messageOf<BadOption>(path, {.without = {"*"}}), HasSubstr("leaves nothing"));
}

// --- Meshes that stand for others -----------------------------------------------------------------------------------

std::vector<std::string> notedNodes(const std::vector<std::pair<std::string, shapes::Shape>>& nodes) {
    GlbWriter file;
    for (const auto& [name, shape] : nodes) file.node(name, file.mesh(shape));
    std::vector<std::string> names;
    for (const RigNote& note : readRig({file.save("twins")}).notes) names.push_back(note.node);
    return names;
}

TEST(RigWhich, CopiesAndHullsAreNoted) {
    const shapes::Shape fine = ball(0.5, 16), coarse = ball(0.52, 6), other = shapes::sphere({1, 0, 0}, 0.5, 6);
    EXPECT_THAT(notedNodes({{"head_LOD0", fine}, {"head_LOD1", coarse}}), ElementsAre("head_LOD1"));
    EXPECT_THAT(notedNodes({{"shell", coarse}, {"head", fine}}), ElementsAre("shell"));
    shapes::Shape box;  // its corners are far from the ball
    for (const float x : {-0.51f, 0.51f})
        for (const float y : {-0.51f, 0.51f})
            for (const float z : {-0.51f, 0.51f}) box.positions.push_back({x, y, z});
    box.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                     {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    EXPECT_THAT(notedNodes({{"head", fine}, {"Cube.001", box}}), ElementsAre("Cube.001"));
    EXPECT_THAT(notedNodes({{"head", fine}, {"UCX_head", other}}), ElementsAre("UCX_head"));
    EXPECT_THAT(notedNodes({{"head", fine}, {"Explode1", other}}), ElementsAre());
    EXPECT_THAT(notedNodes({{"head", fine}, {"head_LOD1", other}}), ElementsAre());  // no other level
}

// --- Pointers -------------------------------------------------------------------------------------------------------

TEST(RigWhich, PointersMoveNodesAndOthersAreNoted) {
    GlbWriter file;
    file.node("ball", file.mesh(ball()));
    const int times = file.scalars({0, 1}), ways = file.vectors({{0, 0, 0}, {2, 0, 0}});
    const auto pointer = [](const std::string& to) {
        return nlohmann::json{{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", to}}}}}};
    };
    file.clip("move", pointer("/nodes/0/translation"), times, ways);
    auto& channels = file.glb.json["animations"][0]["channels"];
    for (const char* other : {"/nodes/0/extensions/KHR_node_visibility/visible", "/nodes/7/scale", "/nodes/x/scale"})
        channels.push_back({{"sampler", 0}, {"target", pointer(other)}});
    const Rig rig = readRig({file.save("pointer")});
    ASSERT_EQ(rig.clips.size(), 1u);
    EXPECT_NEAR(posedAt(rig, 0, 1)[0].x - posedAt(rig, 0, 0)[0].x, 2, 1e-6);
    ASSERT_EQ(rig.notes.size(), 3u);
    EXPECT_EQ(rig.notes[0].node, "ball");
    EXPECT_THAT(rig.notes[0].effect, HasSubstr("shown"));
}

// --- Sizes ----------------------------------------------------------------------------------------------------------

TEST(RigWhich, VerticesOfNoTriangleChangeNothing) {
    const shapes::Shape clean = ball();
    shapes::Shape stray = clean;
    stray.positions.insert(stray.positions.begin() + 5, {2000, 0, 0});
    for (Triangle& t : stray.triangles)
        for (std::uint32_t& corner : t) corner += corner >= 5;
    stray.positions.push_back(clean.positions[3]);
    const auto meshOf = [](const shapes::Shape& shape, const char* name) {
        GlbWriter file;
        file.node("ball", file.mesh(shape));
        return readRig({file.save(name)}).mesh;
    };
    const Mesh a = meshOf(clean, "clean"), b = meshOf(stray, "stray");
    EXPECT_EQ(a.rest_positions, b.rest_positions);
    EXPECT_EQ(a.triangles, b.triangles);
    ASSERT_EQ(b.source_vertex.size(), a.source_vertex.size() + 2);
    EXPECT_EQ(b.source_vertex.back(), b.source_vertex[3]);  // the point at its place
    EXPECT_EQ(b.source_vertex[5], b.source_vertex[4]);      // or that of its neighbour
}

TEST(CharacterBox, FarThingsDoNotCount) {
    shapes::Shape all = ball(1, 40);
    const BoundingBox alone = characterBox(all.triangles, all.positions);
    EXPECT_EQ(alone.low, boundsOf(all.positions).low);
    EXPECT_EQ(alone.high, boundsOf(all.positions).high);
    // A floor of 100 x 100 squares has six times as many triangles as the ball.
    shapes::Shape floor;
    for (int i = 0; i <= 100; ++i)
        for (int j = 0; j <= 100; ++j) floor.positions.push_back({float(10 * i - 505), -1, float(10 * j - 505)});
    for (std::uint32_t i = 0; i < 100; ++i)
        for (std::uint32_t j = 0; j < 100; ++j) {
            const std::uint32_t a = 101 * i + j;
            floor.triangles.push_back({a, a + 1, a + 101});
            floor.triangles.push_back({a + 1, a + 102, a + 101});
        }
    shapes::append(all, floor);
    shapes::append(all, shapes::sphere({0, 3000, 0}, 0.1, 4));
    const BoundingBox box = characterBox(all.triangles, all.positions);
    EXPECT_LT(box.radius(), kKeptReach * alone.radius());
    EXPECT_EQ(box.high.y, alone.high.y);
}

TEST(CharacterBox, NumbersThatAreNotFiniteEndNothing) {
    shapes::Shape shape = ball();
    shape.positions[4].x = INFINITY;
    shape.positions[5].y = NAN;
    (void)characterBox(shape.triangles, shape.positions);
}

// A mesh in centimetres under bones of scale 0.01 is framed as it stands in the scene.
TEST(RestInScene, OtherUnitsOfTheBindSpaceAreUndone) {
    const std::vector<Vec3> rest = {{0, 0, 0}, {0, 180, 0}};
    const std::vector<std::uint16_t> joints = {0, 0};
    const std::vector<float> weights = {1, 1};
    const auto framed = [&](float scale) {
        const Affine bone{{scale, 0, 0, 5, 0, scale, 0, 0, 0, 0, scale, 0}};
        return restInScene(rest, {1, joints, weights}, std::array{bone});
    };
    EXPECT_EQ(framed(0.7f), rest);
    EXPECT_NEAR(framed(0.01f)[1].y, 1.8, 1e-6);
    EXPECT_EQ(framed(0.01f)[0].x, 5);
    EXPECT_EQ(framed(0), rest);
}

// --- Mirrors --------------------------------------------------------------------------------------------------------

TEST(RigWhich, TheOutsideStaysOutsideWhereAClipMirrors) {
    for (const float at_rest : {1.0f, -1.0f}) {
        GlbWriter file;
        const int node = file.node("ball", file.mesh(ball()));
        file.glb.json["nodes"][0]["scale"] = {at_rest, 1, 1};
        file.clip("flip", {{"node", node}, {"path", "scale"}}, file.scalars({0, 1}),
                  file.vectors({{1, 1, 1}, {-1, 1, 1}}), "STEP");
        const Rig rig = readRig({file.save("flip")});
        for (const auto& [clip, time] : {std::pair(-1, 0.0), {0, 0.0}, {0, 1.0}}) {
            std::vector<Vec3> normals;
            const std::vector<Vec3> positions = posedAt(rig, clip, time, &normals);
            for (std::size_t v = 0; v < positions.size(); ++v)
                EXPECT_GT(dot(normalized(positions[v]), normals[v]), 0.9f) << at_rest << " at " << time;
        }
    }
}

// --- Polygons -------------------------------------------------------------------------------------------------------

// The L has corners in the middle of its edges; the area is 3, and each corner has a triangle with an area.
TEST(CutPolygon, CornersOnLinesAreKept) {
    const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0},    {2, 0, 0}, {2, 0.5f, 0}, {2, 1, 0},   {1, 1, 0},
                                      {1, 2, 0}, {0.5f, 2, 0}, {0, 2, 0}, {0, 1, 0},    {0, 0.5f, 0}};
    for (const float scale : {1.0f, 1e-4f}) {
        std::vector<Vec3> scaled;
        std::vector<std::uint32_t> corners;
        for (const Vec3 p : points) {
            corners.push_back(std::uint32_t(scaled.size()));
            scaled.push_back(p * scale);
        }
        std::vector<Triangle> triangles;
        cutPolygon(scaled, corners, triangles);
        EXPECT_EQ(triangles.size(), points.size() - 2);
        double area = 0;
        std::vector<bool> used(points.size());
        for (const Triangle& t : triangles) {
            const Vec3d a = toDouble(scaled[t[0]]);
            const Vec3d twice = cross(toDouble(scaled[t[1]]) - a, toDouble(scaled[t[2]]) - a);
            EXPECT_GT(twice.z, 0);
            area += 0.5 * twice.z;
            for (const std::uint32_t corner : t) used[corner] = true;
        }
        EXPECT_NEAR(area / (scale * double(scale)), 3, 1e-5);
        EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
    }
}

// Where the corner on the line stands does not matter.
TEST(CutPolygon, QuadsWithACornerOnALineKeepIt) {
    const std::vector<Vec3> points = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {2, 0, 1}};
    for (std::uint32_t first = 0; first < 4; ++first) {
        std::vector<Triangle> triangles;
        const std::vector<std::uint32_t> corners = {first, (first + 1) % 4, (first + 2) % 4, (first + 3) % 4};
        cutPolygon(points, corners, triangles);
        ASSERT_EQ(triangles.size(), 2u);
        for (const Triangle& t : triangles)
            EXPECT_NEAR(length(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]])), 2, 1e-6) << first;
    }
}

}  // namespace
}  // namespace penumbra::test_rig_which
