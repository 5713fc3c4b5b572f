// The vertices of a scene: what they see past everyone else.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>

#include "formats/common/errors.h"
#include "pack/pack_asset.h"
#include "player/papers/cast_shader.h"
#include "player/papers/sphere_cast.h"
#include "player/scene/cast_on.h"
#include "player/scene/probe.h"
#include "player/scene/received_light.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"
#include "sh/visibility_convention.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_scene_receivers {
namespace {

namespace fs = std::filesystem;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

// A folder with tube.pnb, which casts, and additive.pnb of convention A4, which does not.
class SceneReceivers : public ::testing::Test {
protected:
    fs::path folder_ = fs::path(::testing::TempDir()) / "scene_receivers";

    void SetUp() override {
        fs::create_directories(folder_);
        synthetic::TubeOptions additive = kTube;
        additive.convention = parseConvention("A4");
        write("tube.pnb", synthetic::composedTube(kTube));
        write("additive.pnb", synthetic::tubeModel(additive));
    }
    void write(const char* name, const Model& model) const {
        const Packed packed = packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
        std::ofstream file(folder_ / name, std::ios::binary);
        file.write(reinterpret_cast<const char*>(packed.bytes.data()), std::streamsize(packed.bytes.size()));
    }
    PosedScene scene(const std::string& members, const std::string& more = "") const {
        return PosedScene(
            parseScene(R"({"version": 1, "characters": [)" + members + "]" + more + "}", "s.json", folder_));
    }
};

FrameVertices alone(const PosedScene& scene, std::size_t member) {
    const Evaluator& evaluator = scene.members()[member]->evaluator;
    FrameVertices vertices;
    skinFrame(evaluator, 1, vertices);
    evaluateCoefficients(evaluator, 1, vertices);
    return vertices;
}

std::vector<float> ambientOf(const PosedScene& scene, std::size_t member, const FrameVertices& vertices) {
    const ModelView& model = scene.members()[member]->asset->view.model;
    std::vector<float> e(vertices.positions.size());
    ambient(model.convention, model.stride, vertices.coefficients, e);
    return e;
}

// Own parts are in the numbers already.
TEST_F(SceneReceivers, HasTheVeryNumbersWhereNobodyElseCasts) {
    const PosedScene one = scene(R"({"asset": "tube.pnb"})");
    EXPECT_EQ(memberVertices(one, 0, 2).coefficients, alone(one, 0).coefficients);
    const PosedScene apart = scene(R"({"asset": "tube.pnb"}, {"asset": "tube.pnb", "position": [9000, 0, 0]})");
    EXPECT_EQ(memberVertices(apart, 0, 2).coefficients, alone(apart, 0).coefficients);
    EXPECT_EQ(memberVertices(apart, 1, 2).positions[0].x - alone(apart, 1).positions[0].x, 9000);
    const PosedScene receiver = scene(R"({"asset": "additive.pnb"}, {"asset": "additive.pnb", "position": [1, 0, 0]})");
    EXPECT_EQ(receiver.cast().casterCount(), 0u);
    EXPECT_EQ(memberVertices(receiver, 0, 1).coefficients, alone(receiver, 0).coefficients);
}

// A level ground takes (1 - n.y) / 2 of a white sky from a point of probe. Measured: 1e-3, of the far numbers' order.
TEST_F(SceneReceivers, ALevelGroundHidesFromProbe) {
    const std::string nobody = R"({"asset": "tube.pnb", "casts": "nothing"})";
    const PosedScene ground = scene(nobody, R"(, "ground": {"height": -1})"),
                     without = scene(nobody, R"(, "ground": {"height": -1, "casts": false})");
    const std::array<ProbePoint, 4> points = {
        {{{}, {0, 1, 0}}, {{}, {0.8f, 0.6f, 0}}, {{}, {0, 0, 1}}, {{}, {0, -1, 0}}}};
    const std::vector<ProbeValue> hidden = probe(ground, points, 1), open = probe(without, points, 1);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(hidden[i].ambient, (1 + double(points[i].normal.y)) / 2, 5e-3) << i;
        EXPECT_NEAR(open[i].ambient, 1, 1e-5) << i;
    }
}

// A point receives pi times what casters hide times what they send, and the same of the ground, whose radiance where
// nobody casts is albedo times that of a white sky.
TEST_F(SceneReceivers, ProbeReceivesWhatIsSent) {
    const PosedScene posed = scene(R"({"asset": "tube.pnb"})", R"(, "ground": {"height": -40})");
    const FrameVertices member = memberVertices(posed, 0, 1);
    const std::vector<Vec3> red(member.positions.size(), Vec3{0.8f, 0, 0});
    std::array<ShiningMember, 1> shining;
    shiningMember(member, posed.members()[0]->asset->view.mesh.triangles, red, shining[0]);
    GroundGlow glow;
    const BoundingBox box = boundsOf(member.positions);
    glow.cast(CastShadow({}), -40, std::array{box.low, box.high}, 1);
    std::array<float, kFarCoefficients> ambient;
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), ambient);
    GroundWeights white;
    for (std::size_t i = 0; i < kFarCoefficients; ++i)
        white[i] = Vec3d{0, 1, 0} * (std::numbers::pi * double(ambient[i]));
    glow.light(white, {0.5f, 0.5f, 0.5f});
    const std::array<ProbePoint, 2> points = {
        {{{box.high.x + 0.3f, (box.low.y + box.high.y) / 2, 0}, {-1, 0, 0}}, {{20, 5, 0}, {0, -1, 0}}}};
    const std::vector<ProbeValue> open = probe(scene(R"({"asset": "tube.pnb"})"), points, 1),
                                  values = probe(posed, points, 1, {}, {&glow, shining});
    EXPECT_GT(open[0].ambient, 0.1);
    EXPECT_LT(open[0].ambient, 0.95);
    EXPECT_NEAR(values[0].received.x, std::numbers::pi * (1 - open[0].ambient) * 0.8, 2e-3);
    EXPECT_NEAR(values[1].received.y, std::numbers::pi * 0.5, 5e-3);
    for (const ProbeValue& value : open) EXPECT_EQ(value.received, Vec3d{});
}

// The ground shows albedo times the hidden share of a white sky times what a member of one colour sends.
TEST_F(SceneReceivers, TheGroundShowsLightOfMembers) {
    const PosedScene posed = scene(R"({"asset": "tube.pnb"})", R"(, "ground": {"height": -1, "size": 3})");
    const GroundVertices ground = groundVertices(posed, 1);
    const FrameVertices member = memberVertices(posed, 0, 1);
    const std::vector<Vec3> red(member.positions.size(), Vec3{0.8f, 0, 0});
    std::array<ShiningMember, 1> shining;
    shiningMember(member, posed.members()[0]->asset->view.mesh.triangles, red, shining[0]);
    std::vector<Vec3> radiance(ground.positions.size());
    addMembersLight(ground, shining, {0.5f, 0.5f, 0.5f}, 2, radiance);
    const std::vector<float> e = groundAmbient(ground);
    Largest apart, most;
    for (std::size_t v = 0; v < e.size(); ++v) {
        const float hidden = 1 - e[v] > 1e-3f ? 1 - e[v] : 0;  // smaller values are not counted
        apart.add(std::abs(radiance[v].x - 0.5f * 0.8f * hidden));
        most.add(radiance[v].x);
        EXPECT_EQ(radiance[v].y, 0);
    }
    EXPECT_LT(apart, 1e-5);
    EXPECT_GT(most, 0.02);
}

// Everyone gets darker near another, in any convention, and as much in one as in another: E of both is one integral.
TEST_F(SceneReceivers, IsDarkerBesideAnother) {
    for (const char* asset : {"tube.pnb", "additive.pnb"}) {
        const PosedScene both =
            scene(R"({"asset": ")" + std::string(asset) + R"("}, {"asset": "tube.pnb", "position": [0.6, 0, 0]})");
        const std::vector<float> before = ambientOf(both, 0, alone(both, 0)),
                                 after = ambientOf(both, 0, memberVertices(both, 0, 1));
        Largest most;
        double sum = 0;
        for (std::size_t v = 0; v < after.size(); ++v) {
            EXPECT_LT(after[v], before[v] + 0.02f) << asset;
            most.add(before[v] - after[v]);
            sum += before[v] - after[v];
        }
        EXPECT_GT(most, 0.15) << asset;
        EXPECT_GT(sum / double(after.size()), 0.01) << asset;
    }
}

// Visibility past another times full visibility is the other's, whatever stands below the horizon.
TEST_F(SceneReceivers, ConventionsAgree) {
    std::vector<std::vector<float>> e;
    for (const char* convention : {"D5", "A5", "B5"}) {
        synthetic::TubeOptions tube = kTube;
        tube.convention = parseConvention(convention);
        Model model = synthetic::tubeModel(tube);
        std::vector<float> moments(25), open(std::size_t(tube.convention.size()));
        std::vector<double> below(25);
        belowHorizonCoefficients(5, below);
        for (std::size_t i = 0; i < 25; ++i) moments[i] = -float(below[i]);
        moments[0] += 2 * std::sqrt(std::numbers::pi_v<float>);
        fromMoments(tube.convention, moments, open);
        for (ClusterModel& cluster : model.clusters) {
            std::fill(cluster.basis.begin(), cluster.basis.end(), 0.0f);
            for (std::size_t i = 0; i < cluster.mean.size(); ++i) cluster.mean[i] = open[i % open.size()];
        }
        write("open.pnb", model);
        const PosedScene both = scene(R"({"asset": "open.pnb"}, {"asset": "tube.pnb", "position": [0.6, 0, 0]})");
        e.push_back(ambientOf(both, 0, memberVertices(both, 0, 1)));
    }
    Largest off_a, off_b;
    double least = 1;
    for (std::size_t v = 0; v < e[0].size(); ++v) {
        off_a.add(std::abs(e[1][v] - e[0][v]));
        off_b.add(std::abs(e[2][v] - e[0][v]));
        least = std::min<double>(least, e[0][v]);
    }
    EXPECT_LT(least, 0.8);
    EXPECT_LT(off_a, 0.02);
    EXPECT_LT(off_b, 0.02);
}

// Vertices between evaluated ones are what they would be.
TEST_F(SceneReceivers, MostOfTheGroundIsInterpolated) {
    const PosedScene stands =
        scene(R"({"asset": "tube.pnb"})", R"(, "ground": {"height": 0.05, "size": 6, "resolution": 122})");
    const GroundVertices ground = groundVertices(stands, 2);
    EXPECT_LT(ground.evaluated, ground.positions.size() / 3);
    GroundVertices all = ground;
    castOn(stands.cast(), {}, {all.positions, all.normals, all.tangents}, 2, all.mirrored);
    const std::vector<float> e = groundAmbient(ground), expected = groundAmbient(all);
    EXPECT_LT(largestDifference(e, expected), 0.005);
}

// A level ground sums what is far at anchors. The bounds are what anchors cost the vertices of two characters 0.55 m
// apart (docs/scene.md).
TEST_F(SceneReceivers, AnchorsOfTheGroundGiveWhatEachPointSees) {
    const PosedScene stand =
        scene(R"({"asset": "tube.pnb", "yaw": 20}, {"asset": "tube.pnb", "position": [0.4, 0, 0.2]},
                                      {"asset": "tube.pnb", "position": [-0.3, 0.1, 0.5], "yaw": 70})",
              R"(, "ground": {"height": -0.05, "size": 3, "resolution": 129})");
    const GroundVertices ground = groundVertices(stand, 2);
    GroundVertices all = ground;
    castOn(stand.cast(), {}, {all.positions, all.normals, all.tangents}, 2, all.mirrored);
    const std::vector<float> e = groundAmbient(ground), expected = groundAmbient(all);
    double squares = 0;
    for (std::size_t v = 0; v < e.size(); ++v) squares += (e[v] - expected[v]) * (e[v] - expected[v]);
    const double rms = std::sqrt(squares / double(e.size())), largest = largestDifference(e, expected);
    std::printf("anchors of a ground: E off by %.4f rms, %.4f at most\n", rms, largest);
    EXPECT_LT(*std::ranges::min_element(expected), 0.6f);
    EXPECT_LT(rms, 0.0018);
    EXPECT_LT(largest, 0.015);
}

// The ground is drawn with fewer triangles than it has. They cover the ground once, face up, and meet along whole
// edges, so that nothing cracks. At their corners stands what all triangles have there.
TEST_F(SceneReceivers, TheGroundIsDrawnWithoutCracks) {
    const PosedScene stands =
        scene(R"({"asset": "tube.pnb"})", R"(, "ground": {"height": 0.05, "size": 6, "resolution": 123})");
    const GroundVertices ground = groundVertices(stands, 2);
    EXPECT_LT(ground.drawn.size(), ground.triangles.size() / 2);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    double area = 0;
    for (std::size_t t = 0; t < ground.drawn.size(); t += 3) {
        const std::uint32_t* v = &ground.drawn[t];
        const Vec3 a = ground.positions[v[0]], b = ground.positions[v[1]], c = ground.positions[v[2]];
        const float up = cross(b - a, c - a).y;
        ASSERT_GT(up, 0);
        area += double(up) / 2;
        for (int e = 0; e < 3; ++e) ++edges[{v[e], v[(e + 1) % 3]}];
    }
    EXPECT_NEAR(area, 36, 1e-3);
    std::size_t rim = 0;
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1);
        if (edges.contains({edge.second, edge.first})) continue;
        ++rim;
        for (const std::uint32_t v : {edge.first, edge.second})
            ASSERT_TRUE(std::abs(std::abs(ground.positions[v].x) - 3) < 1e-5f ||
                        std::abs(std::abs(ground.positions[v].z) - 3) < 1e-5f);
    }
    EXPECT_LE(rim, 4u * 122u);
}

// The shadow of what was baked beside a character, and stood still, lies beside the character. A yaw of 90 degrees
// turns +x towards -z.
TEST_F(SceneReceivers, StillPartsStandWithTheirCharacter) {
    Model model = synthetic::composedTube(kTube);
    synthetic::addStillBall(model, {1.5f, 0.3f, 0});
    write("beside.pnb", model);
    const PosedScene stands = scene(R"({"asset": "beside.pnb", "position": [2, 0, 1], "yaw": 90})",
                                    R"(, "ground": {"height": 0, "size": 8, "resolution": 81})");
    const GroundVertices ground = groundVertices(stands, 2);
    const std::vector<float> e = groundAmbient(ground);
    const auto at = [&](float x, float z) {
        const auto nearest = std::ranges::min_element(ground.positions, {}, [&](Vec3 p) {
            return length(Vec3{p.x - x, 0, p.z - z});
        });
        return e[std::size_t(nearest - ground.positions.begin())];
    };
    EXPECT_LT(at(2, -0.5f), 0.7f);
    for (const auto& [x, z] : {std::pair(1.5f, 0.0f), {3.5f, 1.0f}, {2.0f, 2.5f}}) EXPECT_GT(at(x, z), 0.85f) << x;
}

TEST_F(SceneReceivers, TheGroundIsDarkestUnderTheCharacter) {
    const PosedScene stands =
        scene(R"({"asset": "tube.pnb"})", R"(, "ground": {"height": 0, "size": 8, "resolution": 33})");
    const GroundVertices ground = groundVertices(stands, 2);
    const std::vector<float> e = groundAmbient(ground);
    ASSERT_EQ(e.size(), 33u * 33u);
    EXPECT_EQ(ground.triangles.size(), 6u * 32u * 32u);
    const std::size_t darkest = std::size_t(std::min_element(e.begin(), e.end()) - e.begin());
    EXPECT_LT(length(ground.positions[darkest]), 0.4f);
    EXPECT_LT(e[darkest], 0.5f);
    EXPECT_GT(e.front(), 0.97f);
    EXPECT_LT(e.front(), 1.0001f);
    // Faces up.
    const Vec3 a = ground.positions[ground.triangles[0]], b = ground.positions[ground.triangles[1]],
               c = ground.positions[ground.triangles[2]];
    EXPECT_GT(cross(b - a, c - a).y, 0);
}

TEST_F(SceneReceivers, SaysWhoseAssetCannotBeRead) {
    std::ofstream(folder_ / "words.pnb") << "words";
    const auto problem = [&](const char* asset) -> std::string {
        try {
            scene(R"({"asset": "tube.pnb"}, {"asset": ")" + std::string(asset) + R"("})");
        } catch (const std::exception& error) {
            return error.what();
        }
        return "";
    };
    for (const char* asset : {"gone.pnb", "words.pnb"}) {
        EXPECT_NE(problem(asset).find("s.json: /characters/1/asset: "), std::string::npos) << problem(asset);
        EXPECT_NE(problem(asset).find(asset), std::string::npos);
    }
    EXPECT_THROW(scene(R"({"asset": "gone.pnb"})"), IoError);
    EXPECT_THROW(scene(R"({"asset": "words.pnb"})"), InvalidInput);
}

// The papers' casters are spheres. Who has none is refused, unless it is to cast nothing.
TEST_F(SceneReceivers, PapersNeedSpheres) {
    const auto posed = [&](CastMode mode, const char* exponential, const std::string& more) {
        PosedScene(
            parseScene(R"({"version": 1, "characters": [{"asset": "tube.pnb")" + more + "}]}", "s.json", folder_),
            {mode, parseCastExponential(exponential)});
    };
    EXPECT_NO_THROW(posed(CastMode::kFolded, "hyb-ps2", ""));
    EXPECT_THROW(posed(CastMode::kSphereProduct, "hyb-ps2", ""), InvalidInput);
    EXPECT_THROW(posed(CastMode::kHemisphereShare, "hyb-ps2", ""), InvalidInput);
    EXPECT_NO_THROW(posed(CastMode::kHemisphereShare, "hyb-ps2", R"(, "casts": "nothing")"));
    EXPECT_THROW(posed(CastMode::kProduct, "chain", ""), UsageError);
}

// Two halves of a field over the sphere have, above a receiver, what its mirrored numbers have.
TEST_F(SceneReceivers, HalvesOfFieldsMakeASphere) {
    const PosedScene one = scene(R"({"asset": "tube.pnb"})");
    const std::vector<Vec3> places = {{0.5f, 0.4f, 0}, {0.3f, 1, 0.3f}}, normals(2, {0, 1, 0}), tangents(2, {0, 0, 1});
    std::vector<float> mirrored, cast;
    castOn(one.cast(), {}, {places, normals, tangents}, 1, mirrored);
    castOverSphere(one.cast(), {}, 5, {places, normals, tangents}, 1, cast);
    const std::vector<Vec3> weights = groundWeights(CastMode::kFolded, {}, 1);
    std::vector<float> of_mirrored(kFarCoefficients);
    ambientWeights(parseConvention("D6"), of_mirrored);
    for (std::size_t r = 0; r < 2; ++r) {
        float e = 0, expected = 0;
        for (std::size_t k = 0; k < weights.size(); ++k) e += weights[k].x * cast[r * weights.size() + k];
        for (std::size_t k = 0; k < kFarCoefficients; ++k)
            expected += of_mirrored[k] * mirrored[r * kFarCoefficients + k];
        EXPECT_LT(expected, 0.98f);
        EXPECT_NEAR(e, expected, 0.01);
    }
}

}  // namespace
}  // namespace penumbra::test_scene_receivers
