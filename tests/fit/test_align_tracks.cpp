// Two tracks of one camera in two frames: the map between them, by all ways, against golden numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "fit/camera/align_tracks.h"
#include "fit/papers/align/two_views.h"
#include "formats/common/errors.h"
#include "sh/quaternion.h"
#include "tests/sh/golden.h"

namespace penumbra::test_align_tracks {
namespace {

using ::testing::HasSubstr;

Mat3d mat3(const nlohmann::json& rows) { return fromRows(vec3(rows.at(0)), vec3(rows.at(1)), vec3(rows.at(2))); }

// Poses of the golden file: places p and turns R from the world to the camera.
std::vector<PosePair> goldenPairs(const nlohmann::json& part) {
    std::vector<PosePair> out;
    for (std::size_t i = 0; i < part.at("p").size(); ++i) {
        const Mat3d a = mat3(part.at("R").at(i)), b = mat3(part.at("Rhat").at(i));
        out.push_back({{a, -(a * vec3(part.at("p").at(i)))}, {b, -(b * vec3(part.at("phat").at(i)))}});
    }
    return out;
}

struct MapError {
    double scale, degrees, origin;
};
MapError errorOf(const FrameMap& map, const nlohmann::json& truth) {
    const Vec3d turn = rotationVector(quaternionOf(transposed(mat3(truth.at("R"))) * map.rotation));
    return {std::abs(map.scale / truth.at("s").get<double>() - 1), length(turn) * 180 / std::numbers::pi,
            length(map.origin - vec3(truth.at("o")))};
}

void expectMap(const FrameMap& map, const nlohmann::json& truth, double tolerance) {
    const MapError error = errorOf(map, truth);
    EXPECT_LE(error.scale, tolerance);
    EXPECT_LE(error.degrees, tolerance * 100);
    EXPECT_LE(error.origin, tolerance);
}

TEST(AlignTracks, IsExactWithoutNoise) {
    const nlohmann::json golden = readGolden("calibration.json");
    const std::vector<PosePair> pairs = goldenPairs(golden.at("exact"));
    const AlignedFrames found = alignFrames(pairs);
    expectMap(found.map, golden.at("truth"), 1e-7);
    EXPECT_LE(found.place_rms, 1e-7);
    EXPECT_LE(found.turn_rms, 1e-5);
    for (const PosePair& pair : pairs) {
        const CameraPose mapped = poseInA(found.map, pair.b);
        EXPECT_LE(length(mapped.place() - pair.a.place()), 1e-7);
    }
}

// Five views with 2 mm and .3 degrees of noise a pose. The golden alternation is off by .0046 in scale, .15 degrees and
// 3.1 mm or less. The bounds here are three times the median errors of such draws.
TEST(AlignTracks, BearsNoise) {
    const nlohmann::json golden = readGolden("calibration.json");
    const MapError error = errorOf(alignFrames(goldenPairs(golden.at("noisy"))).map, golden.at("truth"));
    EXPECT_LE(error.scale, 0.01);
    EXPECT_LE(error.degrees, 0.6);
    EXPECT_LE(error.origin, 0.006);
}

// A frame whose pose is wrong changes nothing that matters.
TEST(AlignTracks, BearsAWrongPose) {
    const nlohmann::json golden = readGolden("calibration.json");
    std::vector<PosePair> pairs = goldenPairs(golden.at("noisy"));
    const std::vector<PosePair> more = goldenPairs(golden.at("exact"));
    pairs.insert(pairs.end(), more.begin(), more.end());
    const MapError before = errorOf(alignFrames(pairs).map, golden.at("truth"));
    pairs[1].a.rotation = matrixOf(rotationOf(Vec3d{0.5, 0.2, 0})) * pairs[1].a.rotation;
    const MapError after = errorOf(alignFrames(pairs).map, golden.at("truth"));
    EXPECT_LE(after.degrees, before.degrees + 0.5);
    EXPECT_LE(after.scale, before.scale + 0.01);
}

TEST(AlignTracks, AlternationHasTheGoldenNumbers) {
    const nlohmann::json golden = readGolden("calibration.json");
    expectMap(alignByAlternation(goldenPairs(golden.at("noisy")), 0.002, 0.005), golden.at("noisy").at("joint"), 1e-9);
    expectMap(alignByAlternation(goldenPairs(golden.at("exact")), 0.002, 0.005), golden.at("truth"), 1e-9);
}

std::string problemOf(const PosePair& first, const PosePair& second) {
    try {
        (void)alignTwoViews(first, second);
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(AlignTracks, ClosedFormNeedsFifteenDegrees) {
    const nlohmann::json golden = readGolden("calibration.json");
    const std::vector<PosePair> pairs = goldenPairs(golden.at("exact"));
    int exact = 0, refused = 0;
    for (const PosePair& one : pairs)
        for (const PosePair& other : pairs) {
            const PosePair both[] = {one, other};
            if (spreadOf(both) >= kMinTwoViewDegrees) {
                ++exact;
                expectMap(alignTwoViews(one, other), golden.at("truth"), 1e-8);
            } else {
                ++refused;
                EXPECT_THAT(problemOf(one, other), HasSubstr("the closed form needs 15"));
            }
        }
    EXPECT_GT(exact, 0);
    EXPECT_GT(refused, 0);
}

// Two cameras above one another: 25 degrees apart, but their rays are parallel in x and y.
TEST(AlignTracks, ClosedFormRefusesOneAzimuth) {
    const Mat3d turn;
    const auto at = [&](Vec3d place) { return CameraPose{turn, -place}; };
    const PosePair low{at({0.8, 0, 0.3}), at({0.8, 0, 0.3})}, high{at({0.8, 0, 0.8}), at({0.8, 0, 0.8})};
    EXPECT_THAT(problemOf(low, high), HasSubstr("share an azimuth"));
}

TEST(AlignTracks, RefuseTooLittle) {
    const std::vector<PosePair> pairs = goldenPairs(readGolden("calibration.json").at("exact"));
    const PosePair still[] = {pairs[0], pairs[0], pairs[0]};
    EXPECT_THROW((void)alignFrames(std::span(pairs).first(1)), InvalidInput);
    EXPECT_THROW((void)alignFrames(still), InvalidInput);
}

TEST(AlignTracks, PairFramesByNameAndElseByNumber) {
    CameraTrack a, b;
    const auto add = [](CameraTrack& track, const char* file) {
        track.frames.emplace_back().file = file;
        track.frames.back().pose = CameraPose{};
    };
    for (const char* file : {"x/1.jpg", "x/2.jpg", "x/3.jpg"}) add(a, file);
    for (const char* file : {"3.jpg", "y/1.jpg"}) add(b, file);
    std::vector<FramePair> pairs = pairFrames(a, b);
    ASSERT_EQ(pairs.size(), 2u);
    EXPECT_EQ(pairs[0].b, 1u);
    EXPECT_EQ(pairs[1].a, 2u);
    a.frames[2].pose.reset();
    EXPECT_EQ(pairFrames(a, b).size(), 1u);
    b.frames[0].file = "z/1.jpg";
    EXPECT_THROW((void)pairFrames(a, b), InvalidInput);
    for (CameraTrack* track : {&a, &b})
        for (TrackFrame& frame : track->frames) frame.file.clear();
    EXPECT_EQ(pairFrames(a, b).size(), 2u);
}

}  // namespace
}  // namespace penumbra::test_align_tracks
