// cam.json, poses.json of cameras and cam.response.json: they come back bit for bit, and what is none is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "formats/camera/camera_file.h"
#include "formats/common/errors.h"
#include "formats/scene/bone_poses.h"

namespace penumbra::test_camera_file {
namespace {

using ::testing::HasSubstr;

const PinholeCamera kCamera{601.25, 322.1, 236.9, 640, 480, -0.21, 1.0 / 17};
const CameraPose kPose{{{0, 1, 0, 0.6, 0, -0.8, -0.8, 0, -0.6}}, {1.0 / 3, -2, 0.45}};

std::filesystem::path written(const std::string& text) {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("penumbra_camera_" + std::to_string(getpid()) + ".json");
    std::ofstream(path) << text;
    return path;
}

std::string problemOf(const std::string& text, auto read) {
    try {
        read(text);
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(CameraFile, ComesBackBitForBit) {
    EXPECT_EQ(readCamera(written(cameraText(kCamera))), kCamera);
    const CameraTrack track{kCamera,
                            {{"a.jpg", kPose, 0.9, 0.11, false}, {"b.jpg", {}, 0, 0, false}, {"", kPose, 0, 2, true}}};
    const std::string text = cameraTrackText(track);
    EXPECT_EQ(cameraTrackText(parseCameraTrack(text, "p.json")), text);
    CameraResponse response = *knownResponse("rec709");
    response.exposure[2][255] = 1.5f;
    EXPECT_EQ(readResponse(written(responseText(response)).string()).exposure, response.exposure);
    EXPECT_EQ(readResponse("srgb").exposure, knownResponse("srgb")->exposure);
}

TEST(CameraFile, NeedsNoMoreThanFocalLengthAndSize) {
    const PinholeCamera camera = readCamera(written(R"({"f": 500, "size": [64, 33]})"));
    EXPECT_EQ(camera, (PinholeCamera{500, 31.5, 16, 64, 33, 0, 0}));
}

TEST(CameraFile, RefusesWithThePlace) {
    const auto read = [](const std::string& text) { (void)readCamera(written(text)); };
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "not JSON"},
        {R"({"size": [64, 33]})", "has no \"f\""},
        {R"({"f": 1, "size": [64]})", "/size: must have 2 numbers"},
        {R"({"f": 1, "size": [64, 0]})", "/size/1: is 0, not in"},
        {R"({"f": -1, "size": [64, 64]})", "/f: is -1, not in"},
        {R"({"f": 64, "size": [64, 64], "k3": 1})", "/k3: unknown key"},
        {R"({"f": 64, "size": [64, 64], "k1": -3})", "fold the picture"},
        {R"({"format": "penumbra.bone_poses", "version": 1})",
         R"(/format: is "penumbra.bone_poses", and not "penumbra.camera")"}};
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(text, read), HasSubstr(expected)) << text;
    EXPECT_THROW((void)readCamera("/nowhere/cam.json"), IoError);
}

TEST(CameraPosesFile, RefusesWithThePlace) {
    const auto read = [](const std::string& text) { (void)parseCameraTrack(text, "p.json"); };
    const auto with = [](const std::string& frames) {
        return R"({"format": "penumbra.camera_poses", "camera": {"f": 64, "size": [64, 64]}, "frames": )" + frames +
               "}";
    };
    const std::string r = R"("R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]])";
    EXPECT_EQ(problemOf(with("[{" + r + R"(, "t": [0, 0, 1]}])"), read), "none");
    EXPECT_EQ(problemOf(with(R"([{"file": "a"}])"), read), "none");
    const std::vector<std::pair<std::string, std::string>> cases = {
        {with("[]"), "p.json: /frames: is empty"},
        {with("[{" + r + "}]"), "p.json: /frames/0: has no \"t\""},
        {with(R"([{"t": [0, 0, 1]}])"), "p.json: /frames/0: has no \"R\""},
        {with("[{" + r + R"(, "t": [0, NaN, 1]}])"), "p.json: not JSON"},
        {with("[{" + r + R"(, "t": [0, 1e300, 1]}])"), "p.json: /frames/0/t/1: is 1e+300, not in"},
        {with(R"([{"R": [[1, 0, 0], [0, 1, 0], [0, 0, -1]], "t": [0, 0, 1]}])"),
         "p.json: /frames/0: has an R that is not a rotation"},
        {with(R"([{"R": [[1, 0, 0], [0, 1, 0]], "t": [0, 0, 1]}])"), "p.json: /frames/0/R: must have 3 rows"},
        {R"({"format": "penumbra.camera_poses", "version": 2})", "p.json: /version: is version 2"},
        {R"({"frames": []})", "p.json: /: has no \"format\""}};
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(text, read), HasSubstr(expected)) << text;
}

TEST(CameraPosesFile, AndPosesOfBonesRefuseEachOtherByName) {
    const std::string cameras = cameraTrackText({kCamera, {{"a.jpg", kPose, 1, 0, false}}});
    const std::string bones = bonePosesText({{"hip"}, {{"walk", 0, {Affine{}}, {0, 0, 0}}}});
    EXPECT_EQ(problemOf(bones, [](const std::string& text) { (void)parseCameraTrack(text, "p.json"); }),
              "p.json: /format: is \"penumbra.bone_poses\", and not \"penumbra.camera_poses\"");
    EXPECT_EQ(problemOf(cameras, [](const std::string& text) { (void)parseBonePoses(text, "p.json"); }),
              "p.json: /format: is \"penumbra.camera_poses\", and not \"penumbra.bone_poses\"");
}

TEST(ResponseFile, RefusesWithThePlace) {
    const auto read = [](const std::string& text) { (void)readResponse(written(text).string()); };
    CameraResponse falls = *knownResponse("linear"), flat;
    falls.exposure[1][200] = 0;
    EXPECT_THAT(problemOf(responseText(falls), read), HasSubstr("/exposure/1: falls where the code grows"));
    EXPECT_THAT(problemOf(responseText(flat), read), HasSubstr("/exposure/0: is the same for every code"));
    EXPECT_THAT(problemOf(R"({"format": "penumbra.camera_response", "exposure": [[1]]})", read),
                HasSubstr("/exposure: must have 3"));
    EXPECT_THROW((void)readResponse("film"), IoError);  // no name that is known, and no file
}

TEST(CameraPosesFile, RefusesEveryTruncation) {
    const std::string whole = cameraTrackText({kCamera, {{"a.jpg", kPose, 1, 0, false}}});
    for (std::size_t n = 0; n + 2 < whole.size(); ++n)
        EXPECT_THROW((void)parseCameraTrack(whole.substr(0, n), "p.json"), InvalidInput) << n << " bytes";
}

}  // namespace
}  // namespace penumbra::test_camera_file
