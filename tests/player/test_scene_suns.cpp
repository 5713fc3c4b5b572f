// Suns among the characters of a scene: their maps on the CPU, and what probe() says of them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "player/scene/probe.h"
#include "player/scene/scene_receivers.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_scene_suns {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

const SunD kSun{{0.6, 0.8, 0}, {3, 2.5, 2}, 0.01};

// A uniform light of radiance 1 and `suns`.
LightFile sunny(std::vector<SunD> suns) {
    LightFile light = synthetic::light(4, 0);
    light.name = "sunny";
    for (const SunD& sun : suns) {
        const SunD negative{sun.direction, -sun.irradiance, 0};
        subtractSuns(std::span(&negative, 1), {}, light.sh);
    }
    light.suns = std::move(suns);
    if (!light.suns.empty()) light.factor = "exact";
    return light;
}

// Two tubes. They have no spheres, so they cast nothing in the modes that need spheres.
class SceneSunsOfProbe : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("scene_suns_" + std::to_string(getpid()));

    void SetUp() override {
        fs::create_directories(folder);
        LightFile two = sunny({kSun, {{0, 0.6, -0.8}, {1, 1, 1}, 0}}), uniform = sunny({});
        two.name = "two";
        uniform.name = "uniform";
        const std::array lights = {sunny({kSun}), two, uniform};
        writeWholeFile(folder / "tube.pnb",
                       packAsset(synthetic::composedTube({.rings = 12, .segments = 9, .joints = 6, .clusters = 4}), {},
                                 lights, {.precision = AssetPrecision::kF32}, "{}", 1)
                           .bytes);
    }
    void TearDown() override { fs::remove_all(folder); }

    PosedScene scene(const std::string& light, const CastWay& way = {}, const char* rotation = "yaw=0") const {
        const std::string more = way.mode == CastMode::kProduct ? "" : R"(, "casts": "nothing")";  // has no spheres
        return PosedScene(
            parseScene(R"({"version": 1, "characters": [{"asset": "tube.pnb")" + more + R"(},
                                     {"asset": "tube.pnb", "position": [0.6, 0, 0.1], "yaw": 40)" +
                           more + R"(}], "light": {"name": ")" + light + R"(", "rotation": ")" + rotation + R"("}})",
                       "s.json", folder),
            way);
    }
};

// The middle of a member, moved along the sun's rays.
Vec3 behind(const PosedScene& scene, std::size_t member, double metres) {
    FrameVertices vertices;
    skinMember(*scene.members()[member], 1, vertices);
    Vec3d middle;
    for (const Vec3 p : vertices.positions) middle += toDouble(p);
    return toFloat(middle / double(vertices.positions.size()) - kSun.direction * metres);
}

// Nothing is near a point 50 m away: pi of the uniform remainder, and the sun under its cosine.
TEST_F(SceneSunsOfProbe, FarPointsHaveTheClosedForm) {
    const PosedScene posed = scene("sunny");
    const SceneSuns suns = sceneSuns(posed, SunChoice::kAuto, 256, 2);
    const Vec3 far{0, 50, 0}, up{0, 1, 0};
    const std::array<ProbePoint, 3> points = {{{far, up}, {far, toFloat(kSun.direction)}, {far, up * -1.0f}}};
    const std::vector<ProbeValue> values = probe(posed, points, 1, suns);
    const double cosines[] = {0.8, 1, 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(values[i].sun_visibility[0], cosines[i] > 0 ? 1 : 0);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(values[i].irradiance[c], pi + kSun.irradiance[c] * cosines[i], 2e-5) << i;
    }
}

// Behind either tube, with casts or without, the map takes all of the sun, and V_c only acts on the remainder: what is
// left is the irradiance of the light without the sun.
TEST_F(SceneSunsOfProbe, AreNeverShadowedTwice) {
    const PosedScene posed = scene("sunny"), without = scene("uniform");
    const SceneSuns suns = sceneSuns(posed, SunChoice::kOn, 512, 1);
    std::vector<ProbePoint> points;
    for (const std::size_t member : {0, 1})
        for (const double metres : {0.4, 0.8})
            points.push_back({behind(posed, member, metres), toFloat(kSun.direction)});
    const std::vector<ProbeValue> values = probe(posed, points, 1, suns), sky = probe(without, points, 1);
    bool someone_casts = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(values[i].sun_visibility[0], 0) << i;
        EXPECT_EQ(values[i].ambient, sky[i].ambient);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(values[i].irradiance[c], sky[i].irradiance[c], 2e-5) << i;
        someone_casts |= sky[i].ambient < 0.99;
    }
    EXPECT_TRUE(someone_casts);
}

TEST_F(SceneSunsOfProbe, TurnWithTheLightAndAddUp) {
    const PosedScene posed = scene("two", {}, "yaw=90");
    const SceneSuns suns = sceneSuns(posed, SunChoice::kAuto, 64, 1);
    ASSERT_EQ(suns.suns.size(), 2u);
    const Vec3d turned = posed.lightRotation() * kSun.direction;
    EXPECT_NEAR(length(toDouble(suns.suns[0].direction) - turned), 0, 1e-6);
    EXPECT_GT(length(turned - kSun.direction), 0.5);
    const std::array<ProbePoint, 1> far = {{{{0, 50, 0}, {0, 1, 0}}}};
    const std::vector<ProbeValue> values = probe(posed, far, 1, suns);
    EXPECT_NEAR(values[0].irradiance.x, pi + 3 * 0.8 + 0.6, 2e-5);
    const std::string csv = probeCsv(posed, far, values, suns.suns.size());
    EXPECT_NE(csv.find(",sh_24,sun_visibility_1,sun_visibility_2,received_r,received_g,received_b\n"), csv.npos) << csv;
    EXPECT_TRUE(csv.ends_with(",1,1,0,0,0\n")) << csv;
}

TEST_F(SceneSunsOfProbe, DoNotDependOnThreads) {
    const PosedScene posed = scene("sunny");
    const SceneSuns one = sceneSuns(posed, SunChoice::kAuto, 100, 1), many = sceneSuns(posed, SunChoice::kAuto, 100, 3);
    EXPECT_TRUE(std::ranges::equal(one.maps[0].maps()[0].depths(), many.maps[0].maps()[0].depths()));
    EXPECT_LT(std::ranges::min(one.maps[0].maps()[0].depths()), 1);
}

TEST_F(SceneSunsOfProbe, AreOnlyWhereTheyCanBe) {
    EXPECT_TRUE(sceneSuns(scene("sunny"), SunChoice::kOff, 64, 1).suns.empty());
    EXPECT_TRUE(sceneSuns(scene("uniform"), SunChoice::kAuto, 64, 1).suns.empty());
    EXPECT_THROW(sceneSuns(scene("uniform"), SunChoice::kOn, 64, 1), UsageError);
    CastWay folded;
    folded.mode = CastMode::kFolded;
    EXPECT_TRUE(sceneSuns(scene("sunny", folded), SunChoice::kAuto, 64, 1).suns.empty());
    EXPECT_THROW(sceneSuns(scene("sunny", folded), SunChoice::kOn, 64, 1), UsageError);
}

}  // namespace
}  // namespace penumbra::test_scene_suns
