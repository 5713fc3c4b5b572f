// The text model of COLMAP: its cameras and poses, and what is no such file or of a lens that is not read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/camera/colmap_model.h"
#include "formats/common/errors.h"

namespace penumbra::test_colmap_model {
namespace {

using ::testing::HasSubstr;

const std::string kImages =
    "# Image list with two lines of data per image:\n"
    "7 0.7071067811865476 0 0 0.7071067811865476 0.5 -0.25 2 1 b.jpg\n"
    "10 20 -1 30 40 5\n"
    "3 1 0 0 0 0 0 1 1 a picture.jpg\n"
    "\n";

TEST(ColmapModel, HasOurPixelsAndPoses) {
    const CameraTrack track = parseColmapModel("# Camera list\n1 RADIAL 640 480 600 320 240 -0.1 0.02\n", kImages, "m");
    EXPECT_EQ(track.camera.f, 600);
    EXPECT_EQ(track.camera.cx, 319.5);  // COLMAP's middle of 640 pixels is 320
    EXPECT_EQ(track.camera.cy, 239.5);
    EXPECT_EQ(track.camera.k1, -0.1);
    EXPECT_EQ(track.camera.k2, 0.02);
    ASSERT_EQ(track.frames.size(), 2u);
    EXPECT_EQ(track.frames[0].file, "a picture.jpg");  // by name
    const CameraPose& pose = *track.frames[1].pose;    // a quarter turn about z: x becomes y
    EXPECT_NEAR(pose.rotation(1, 0), 1, 1e-12);
    EXPECT_NEAR(pose.rotation(0, 1), -1, 1e-12);
    EXPECT_EQ(pose.translation, (Vec3d{0.5, -0.25, 2}));
}

TEST(ColmapModel, ReadsFourModelsAndNamesOthers) {
    const std::pair<const char*, const char*> cases[] = {{"SIMPLE_PINHOLE", "600 320 240"},
                                                         {"PINHOLE", "600 600.5 320 240"},
                                                         {"SIMPLE_RADIAL", "600 320 240 0.1"},
                                                         {"RADIAL", "600 320 240 0.1 0"}};
    for (const auto& [model, numbers] : cases) {
        const std::string camera = std::string("1 ") + model + " 640 480 " + numbers + "\n";
        EXPECT_NEAR(parseColmapModel(camera, kImages, "m").camera.f, 600, 0.3) << model;
    }
    const auto unsupported = [](const std::string& camera) -> std::string {
        try {
            (void)parseColmapModel(camera, kImages, "m");
        } catch (const Unsupported& problem) {
            return problem.what();
        }
        return "none";
    };
    EXPECT_THAT(unsupported("1 OPENCV 640 480 600 600 320 240 0 0 0 0"), HasSubstr("camera model OPENCV"));
    EXPECT_THAT(unsupported("1 PINHOLE 640 480 600 660 320 240"), HasSubstr("pixels must be square"));
    // A camera that no image uses may be of any model.
    EXPECT_EQ(unsupported("2 OPENCV 640 480 600 600 320 240 0 0 0 0\n1 SIMPLE_PINHOLE 640 480 600 320 240"), "none");
    EXPECT_THROW(
        (void)parseColmapModel("1 SIMPLE_PINHOLE 640 480 600 320 240", kImages + "4 1 0 0 0 0 0 1 2 c.jpg\n\n", "m"),
        Unsupported);
}

std::string problemOf(const std::string& cameras, const std::string& images) {
    try {
        (void)parseColmapModel(cameras, images, "m");
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(ColmapModel, RefusesWithTheLine) {
    const std::string camera = "1 SIMPLE_PINHOLE 640 480 600 320 240\n";
    const std::vector<std::pair<std::string, std::string>> images = {
        {"", "m/images.txt: has no images"},
        {"# only\n", "m/images.txt: has no images"},
        {"1 1 0 0 0 0 0 1 1\n", "m/images.txt: line 1: has no NAME"},
        {"1 1 0 0 0 0 0 1 1 a\tb\n", "line 1: NAME has a control character"},
        {"# x\n1 0 0 0 0 0 0 1 1 a\n", "line 2: QW QX QY QZ are all 0"},
        {"1 nan 0 0 0 0 0 1 1 a\n", "line 1: QW must be a number up to 2, not 'nan'"},
        {"1 1 0 0 0 0 0 1e99 1 a\n", "line 1: TZ must be a number"},
        {"1 1 0 0 0 0 0 1 1.5 a\n", "line 1: CAMERA_ID must be a whole number"},
        {"1 1 0 0 0 0 0 1 1 a\n\n2 1 0 0 0 0 0 1 1 a\n\n", "line 3: 'a' occurs twice"},
        {"1 1 0 0 0 0 0 1 9 a\n", "m/cameras.txt: has no camera 9"},
    };
    for (const auto& [text, expected] : images) EXPECT_THAT(problemOf(camera, text), HasSubstr(expected)) << text;
    const std::vector<std::pair<std::string, std::string>> cameras = {
        {"1 SIMPLE_PINHOLE 640 480 600 320\n", "m/cameras.txt: line 1: cy must be a number"},
        {"1 SIMPLE_PINHOLE 640 480 600 320 240 1\n", "line 1: more numbers than SIMPLE_PINHOLE has"},
        {"1 SIMPLE_PINHOLE 0 480 600 320 240\n", "line 1: the camera has no pixels"},
        {"1 SIMPLE_PINHOLE 640 480 -600 320 240\n", "line 1: the camera has a focal length that is not above 0"},
        {"1 SIMPLE_PINHOLE 99999 480 600 320 240\n", "line 1: WIDTH must be a number up to 32768"},
        {camera + camera, "line 2: camera 1 occurs twice"},
        {"one\n", "line 1: CAMERA_ID must be a number"},
    };
    for (const auto& [text, expected] : cameras) EXPECT_THAT(problemOf(text, kImages), HasSubstr(expected)) << text;
}

// A model that is cut short is refused or has fewer images; nothing else happens.
TEST(ColmapModel, BearsEveryTruncation) {
    const std::string camera = "1 SIMPLE_PINHOLE 640 480 600 320 240\n";
    for (std::size_t n = 0; n < kImages.size(); ++n) {
        try {
            EXPECT_LE(parseColmapModel(camera, kImages.substr(0, n), "m").frames.size(), 2u);
        } catch (const InvalidInput&) {
        }
    }
    for (std::size_t n = 0; n + 5 < camera.size(); ++n)  // "2" of 240 is a whole number, too
        EXPECT_THROW((void)parseColmapModel(camera.substr(0, n), kImages, "m"), std::runtime_error) << n;
}

}  // namespace
}  // namespace penumbra::test_colmap_model
