// scene.json: what it says, and what is refused with the place where it stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "formats/scene/scene_origin.h"
#include "formats/scene/scene_placement.h"

namespace penumbra::test_scene_file {
namespace {

using ::testing::HasSubstr;

SceneDescription parsed(const std::string& text) { return parseScene(text, "s.json", "/folder"); }

std::string problemOf(const std::string& text) {
    try {
        (void)parsed(text);
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

// A scene with one character, and `more` behind it.
std::string sceneWith(const std::string& more) {
    return R"({"version": 1, "characters": [{"asset": "a.pnb"}])" + more + "}";
}

std::string sceneOf(const std::string& character) { return R"({"version": 1, "characters": [)" + character + "]}"; }

TEST(SceneFile, ReadsAllKeys) {
    const SceneDescription scene = parsed(R"({
        "version": 1,
        "characters": [
            {"name": "hero", "asset": "a.pnb", "clip": "walk", "time": 1.5, "position": [1, 2, -3], "yaw": 90, "scale": 1,
             "material": "clay", "slots": {"body": "skin"}},
            {"asset": "sub/a.pnb", "pose": {"file": "a.poses.json", "frame": 3}}, {"asset": "a.pnb"}],
        "props": [{"asset": "/elsewhere/table.pnb", "position": [0, 0, 1]}],
        "ground": {"height": -0.5, "centre": [1, 0, 2], "size": 8, "resolution": 64, "albedo": [0.1, 0.2, 0.3]},
        "light": {"asset": "lights.pnb", "name": "sky", "rotation": "yaw=30"},
        "camera": "yaw=20"})");
    ASSERT_EQ(scene.characters.size(), 3u);
    const SceneCharacter& hero = scene.characters[0];
    EXPECT_EQ(hero.name, "hero");
    EXPECT_EQ(hero.asset, "/folder/a.pnb");
    EXPECT_EQ(hero.clip, "walk");
    EXPECT_EQ(hero.seconds, 1.5);
    EXPECT_EQ(hero.position.z, -3);
    EXPECT_EQ(hero.yaw, 90);
    EXPECT_EQ(hero.material, "clay");
    EXPECT_EQ(hero.slots.front(), (std::pair<std::string, std::string>("body", "skin")));
    EXPECT_FALSE(hero.pose);
    EXPECT_EQ(scene.characters[1].name, "a");
    ASSERT_TRUE(scene.characters[1].pose);
    EXPECT_EQ(scene.characters[1].pose->file, "/folder/a.poses.json");
    EXPECT_EQ(scene.characters[1].pose->frame, 3u);
    EXPECT_EQ(scene.characters[2].name, "a-2");
    EXPECT_EQ(scene.props[0].asset, "/elsewhere/table.pnb");
    ASSERT_TRUE(scene.ground);
    EXPECT_EQ(scene.ground->height, -0.5);
    EXPECT_EQ(scene.ground->resolution, 64);
    EXPECT_EQ(scene.ground->albedo.y, 0.2f);
    EXPECT_EQ(scene.light.asset, "/folder/lights.pnb");
    EXPECT_EQ(scene.camera, "yaw=20");
    const std::vector<std::filesystem::path> files = {"/folder/a.pnb", "/folder/sub/a.pnb", "/folder/a.poses.json",
                                                      "/elsewhere/table.pnb", "/folder/lights.pnb"};
    EXPECT_EQ(filesNamedIn(scene), files);
}

TEST(SceneFile, RefusesWithThePlace) {
    const auto character = [](const std::string& key_and_value) {
        return sceneOf(R"({"asset": "a.pnb", )" + key_and_value + "}");
    };
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "s.json: not JSON"},
        {"[1, 2", "s.json: not JSON"},
        {"[]", "s.json: /: must be an object"},
        {"{}", "s.json: /: has no \"version\""},
        {R"({"version": 3, "people": []})",
         "s.json: /version: is version 3 of penumbra.scene, and this build reads version 1 alone: make"},
        {R"({"version": "1", "characters": []})", "s.json: /version: must be a whole number"},
        {sceneOf("{}"), "s.json: /characters/0: has no \"asset\""},
        {sceneOf(R"({"asset": ""})"), "s.json: /characters/0/asset: is empty"},
        {sceneOf(R"({"asset": "a\u0000b"})"), "s.json: /characters/0/asset: has a control character"},
        {sceneOf("7"), "s.json: /characters/0: must be an object"},
        {sceneWith(R"(, "sun": {})"), "s.json: /sun: unknown key"},
        {character(R"("yav": 3)"), "s.json: /characters/0/yav: unknown key"},
        {character(R"("casts": "light")"), "s.json: /characters/0/casts: must be fields, spheres or nothing"},
        {character(R"("casts": 1)"), "s.json: /characters/0/casts: "},
        {character(R"("yaw": NaN)"), "s.json: not JSON"},
        {character(R"("yaw": 1e999)"), "s.json: not JSON"},
        {character(R"("yaw": "3")"), "s.json: /characters/0/yaw: must be a number"},
        {character(R"("time": -1)"), "s.json: /characters/0/time: is -1, not in [0, 1e+06]"},
        {character(R"("pose": "a.poses.json")"), "s.json: /characters/0/pose: must be an object"},
        {character(R"("pose": {})"), "s.json: /characters/0/pose: has no \"file\""},
        {character(R"("pose": {"file": "p.json", "frame": -1})"), "s.json: /characters/0/pose/frame: is -1"},
        {character(R"("pose": {"file": "p.json", "time": 1})"), "s.json: /characters/0/pose/time: unknown key"},
        {character(R"("pose": {"file": "p.json"}, "time": 1)"),
         "s.json: /characters/0/pose: cannot stand beside a \"time\": give one of them"},
        {sceneWith(R"(, "props": [{"asset": "p.pnb", "pose": {}}])"), "s.json: /props/0/pose: unknown key"},
        {character(R"("scale": 2)"), "s.json: /characters/0/scale: must be 1: fields and models are made for one size"},
        {character(R"("position": [0, 0])"), "s.json: /characters/0/position: must have 3 numbers"},
        {character(R"("position": [0, 1e9, 0])"), "s.json: /characters/0/position/1: is 1e+09"},
        {character(R"("slots": ["body"])"), "s.json: /characters/0/slots: must be an object"},
        {sceneOf(R"({"name": "x", "asset": "a.pnb"}, {"name": "x", "asset": "b.pnb"})"),
         "s.json: /characters/1/name: \"x\" is also the name of /characters/0"},
        {sceneWith(R"(, "props": [{"asset": "p.pnb", "clip": "walk"}])"), "s.json: /props/0/clip: unknown key"},
        {sceneWith(R"(, "ground": {"resolution": 1})"), "s.json: /ground/resolution: is 1, not in [2, 2048]"},
        {sceneWith(R"(, "ground": {"resolution": 2.5})"), "s.json: /ground/resolution: must be a whole number"},
        {sceneWith(R"(, "ground": {"casts": "fields"})"), "s.json: /ground/casts: "},
        {sceneWith(R"(, "ground": {"albedo": [0, 2, 0]})"), "s.json: /ground/albedo/1: is 2, not in [0, 1]"},
        {sceneWith(R"(, "camera": {})"), "s.json: /camera: has no \"size\""},
        {sceneWith(R"(, "camera": 3)"), "s.json: /camera: must be a string"},
        {R"({"version": 1, "version": 1, "characters": []})", "s.json: /version: occurs twice"},
        {sceneOf(R"({"asset": "a.pnb"}, {"asset": "b.pnb", "position": [1, 2, 3], "yaw": 1, "yaw": 2})"),
         "s.json: /characters/1/yaw: occurs twice"},
        {sceneWith(R"(, "light": )" + std::string(100000, '[')), "s.json: nested too deep"},
    };
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(text), HasSubstr(expected)) << text.substr(0, 200);
}

// A second, and not the minutes of a reader that looks through all elements again at the end of each.
TEST(SceneFile, RefusesACrowdThatNobodyCanMean) {
    std::string crowd;
    for (int i = 0; i < 1000000; ++i) crowd += i == 0 ? "{}" : ",{}";
    EXPECT_THAT(problemOf(sceneOf(crowd)), HasSubstr("/characters: has 1000000 elements; at most 10000"));
}

std::string heightsWith(const std::string& keys) {
    return R"({"version": 1, "characters": [{"asset": "a.pnb", "on_ground": true}], "ground": {"heights": {)" + keys +
           "}}}";
}

TEST(SceneFile, ReadsAGroundWithHeights) {
    const SceneDescription scene = parsed(R"({"version": 1, "characters": [{"asset": "a.pnb", "on_ground": true}],
        "ground": {"height": -1, "material": "sand", "heights": {"file": "dem.npz", "array": "elevation",
        "cells": [30, 20], "scale": 0.1, "offset": -23, "border": "periodic", "no_data": -32768, "fill": 0, "fps": 10,
        "time": 2, "order": 4, "step": 2, "refine": 0.05}}})");
    ASSERT_TRUE(scene.ground && scene.ground->heights);
    const SceneHeights& heights = *scene.ground->heights;
    EXPECT_EQ(heights.source.file, "/folder/dem.npz");
    EXPECT_EQ(heights.source.array, "elevation");
    EXPECT_EQ(heights.source.cell_columns, 30);
    EXPECT_EQ(heights.source.cell_rows, 20);
    EXPECT_EQ(heights.source.border, HeightBorder::kPeriodic);
    EXPECT_EQ(heights.source.no_data, -32768);
    EXPECT_EQ(heights.source.fill, 0);
    EXPECT_EQ(heights.seconds, 2);
    EXPECT_EQ(heights.order, 4);
    EXPECT_EQ(heights.step, 2);
    EXPECT_EQ(heights.refine, 0.05);
    EXPECT_EQ(scene.ground->material, "sand");
    EXPECT_TRUE(scene.characters[0].on_ground);
    EXPECT_EQ(filesNamedIn(scene).back(), "/folder/dem.npz");
    EXPECT_EQ(parsed(heightsWith(R"("analytic": "waves", "rows": 5)")).ground->heights->source.rows, 5);
    const auto refineOf = [](const char* key) {
        return parsed(heightsWith(R"("analytic": "waves")" + std::string(key))).ground->heights->refine;
    };
    EXPECT_EQ(refineOf(""), double(kHeightTolerance));
    EXPECT_EQ(refineOf(R"(, "refine": true)"), double(kHeightTolerance));
    EXPECT_EQ(refineOf(R"(, "refine": false)"), 0);
}

// Places count from the origin afterwards, in steps that floats take away exactly. Who counts from the ground keeps its
// y, and the steps of the heights are taken from their offset, before these become floats.
TEST(SceneOrigin, IsNearTheFirstMember) {
    const auto moved = [](const std::string& place, const std::string& ground) {
        SceneDescription scene =
            parsed(R"({"version": 1, "characters": [{"asset": "a.pnb", )" + place +
                   R"(}], "props": [{"asset": "b.pnb", "position": [40000, 1, 2]}], "ground": {)" + ground + "}}");
        const std::optional<GroundHeights> heights = openGround(scene);
        return std::pair(scene, heights ? heights->heightAt(double(scene.characters[0].position.x), 0) : 0.0);
    };
    const auto [near, none] = moved(R"("position": [500, 7, -511])", R"("height": 3)");
    EXPECT_EQ(near.origin, Vec3d());
    EXPECT_EQ(near.characters[0].position, (Vec3{500, 7, -511}));
    const auto [far, no] =
        moved(R"("position": [40001.5, 7, -2000], "on_ground": true)", R"("height": 9001.25, "centre": [40000, 0, 0])");
    EXPECT_EQ(far.origin, (Vec3d{39936, 9216, -2048}));
    EXPECT_EQ(far.characters[0].position, (Vec3{65.5f, 7, 48}));
    EXPECT_EQ(far.props[0].position, (Vec3{64, -9215, 2050}));
    EXPECT_EQ(far.ground->center, (Vec3{64, 0, 2048}));
    EXPECT_EQ(far.ground->height, 9001.25 - 9216);
    const auto [high, y] = moved(R"("position": [1.5, 7, 0], "on_ground": true)",
                                 R"("height": 2500.5, "heights": {"analytic": "waves:height=0", "offset": 9000.25})");
    EXPECT_EQ(high.origin, (Vec3d{0, 11264, 0}));
    EXPECT_EQ(high.ground->heights->source.offset, 9000.25 - 9216);
    EXPECT_EQ(high.ground->height, 2500.5 - 2048);
    EXPECT_EQ(y, 2500.5 + 9000.25 - 11264);
    const std::vector<Vec3> points = {{0, 0, 0}};
    EXPECT_EQ(cameraOf(high, "target=1/11265/2", points).target, (Vec3d{1, 1, 2}));
    EXPECT_EQ(cameraOf(high, "", points).target, Vec3d());
}

TEST(SceneFile, RefusesHeightsWithThePlaceOfWhatIsWrong) {
    for (const auto& [keys, problem] : std::initializer_list<std::pair<const char*, const char*>>{
             {R"("cell": 1)", "/ground/heights: has either a \"file\" or an \"analytic\""},
             {R"("file": "a", "analytic": "waves")", "either"},
             {R"("file": "a", "rows": 4)", "/ground/heights/rows: is only for \"analytic\""},
             {R"("analytic": "waves", "fill": 4)", "/ground/heights/fill: is only for a \"file\""},
             {R"("analytic": "waves", "columns": 65537)", "/ground/heights/columns"},
             {R"("file": "a", "cell": 0)", "/ground/heights/cell"},
             {R"("file": "a", "cell": 1, "cells": [1, 1])", "/ground/heights/cells: cannot stand beside"},
             {R"("file": "a", "border": "torn")", "must be clamped, periodic or open"},
             {R"("file": "a", "step": 3)", "must be 1, 2, 4 or 8"},
             {R"("file": "a", "order": 6)", "/ground/heights/order"},
             {R"("file": "a", "refine": 0)", "/ground/heights/refine"},
             {R"("file": "a", "refine": "much")", "/ground/heights/refine"},
             {R"("file": "a", "hight": 6)", "/ground/heights/hight: unknown key"}})
        EXPECT_THAT(problemOf(heightsWith(keys)), HasSubstr(problem)) << keys;
    EXPECT_THAT(problemOf(R"({"version": 1, "characters": [{"asset": "a.pnb", "on_ground": true}]})"),
                HasSubstr("/characters/0/on_ground: the scene has no ground"));
    EXPECT_THAT(problemOf(sceneOf(R"({"asset": "a.pnb", "on_ground": 1})")), HasSubstr("must be true or false"));
    EXPECT_THAT(problemOf(R"({"version": 1, "characters": [{"asset": "a.pnb"}],
        "ground": {"size": 4, "heights": {"analytic": "waves"}}})"),
                HasSubstr("/ground/size: is only for a ground without"));
    EXPECT_THAT(problemOf(sceneWith(R"(, "ground": {"casts": false, "heights": {"analytic": "waves"}})")),
                HasSubstr("s.json: /ground/casts: is only for a ground without heights"));
    EXPECT_TRUE(parsed(sceneWith(R"(, "ground": {})")).ground->casts);
    EXPECT_FALSE(parsed(sceneWith(R"(, "ground": {"casts": false})")).ground->casts);
    EXPECT_THAT(problemOf(sceneWith(R"(, "ground": {"material": "clay"})")),
                HasSubstr("is only for a ground with heights"));
}

}  // namespace
}  // namespace penumbra::test_scene_file
