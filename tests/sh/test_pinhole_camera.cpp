// Real cameras: projection and its inverse, what no camera can be, the frames of marker and scene, and responses.
#include <cmath>
#include <limits>
#include <numbers>

#include "sh/camera_response.h"
#include "sh/pinhole_camera.h"
#include "tests/sh/golden.h"

namespace penumbra::test_pinhole_camera {
namespace {

const PinholeCamera kPlain{640, 319.5, 239.5, 640, 480, 0, 0};
const PinholeCamera kLens{600, 322.25, 236.5, 640, 480, -0.21, 0.06};

TEST(PinholeCamera, ProjectsAsItsFormulaSays) {
    // x/z = .25 and y/z = -.5: r^2 = .3125, and the lens scales by 1 - .21 r^2 + .06 r^4 = .940234375.
    const auto at = project(kLens, {0.5, -1, 2});
    ASSERT_TRUE(at);
    EXPECT_NEAR(at->x, 322.25 + 600 * .25 * .940234375, 1e-9);
    EXPECT_NEAR(at->y, 236.5 - 600 * .5 * .940234375, 1e-9);
    EXPECT_FALSE(project(kLens, {0, 0, 0}));
    EXPECT_FALSE(project(kLens, {0, 0, -1}));
    EXPECT_NEAR(project(kPlain, {0, 0, 3})->x, 319.5, 1e-12);  // pixel centers are whole numbers
}

TEST(PinholeCamera, RaysAreSeenWhereTheyComeFrom) {
    for (const PinholeCamera& camera : {kPlain, kLens})
        for (double x : {0.0, 17.5, 320.0, 639.0})
            for (double y : {0.0, 200.25, 479.0}) {
                const Vec3d ray = viewRay(camera, {x, y});
                EXPECT_NEAR(length(ray), 1, 1e-14);
                const auto back = project(camera, 7 * ray);
                ASSERT_TRUE(back);
                EXPECT_NEAR(back->x, x, 1e-7);
                EXPECT_NEAR(back->y, y, 1e-7);
            }
}

TEST(PinholeCamera, NamesWhatCannotBe) {
    EXPECT_EQ(findProblem(kPlain), "");
    EXPECT_EQ(findProblem(kLens), "");
    const auto problem = [](auto change) {
        PinholeCamera camera = kLens;
        change(camera);
        return findProblem(camera);
    };
    EXPECT_NE(problem([](PinholeCamera& c) { c.f = 0; }), "");
    EXPECT_NE(problem([](PinholeCamera& c) { c.width = 0; }), "");
    EXPECT_NE(problem([](PinholeCamera& c) { c.cx = std::numeric_limits<double>::quiet_NaN(); }), "");
    // r (1 - .9 r^2) grows up to r = .61 only, where the lens shows .41; the corners are at .67.
    EXPECT_NE(problem([](PinholeCamera& c) { c.k1 = -0.9, c.k2 = 0; }), "");
}

TEST(CameraPose, StandsWhereItSays) {
    // A camera 2 m above the marker that looks straight down, with the marker's x to its right.
    const CameraPose pose{{{1, 0, 0, 0, -1, 0, 0, 0, -1}}, {0, 0, 2}};
    EXPECT_EQ(findProblem(pose), "");
    EXPECT_LT(length(pose.place() - Vec3d{0, 0, 2}), 1e-15);
    CameraPose mirrored = pose, scaled = pose, lost = pose;
    mirrored.rotation.m[0] = -1;
    scaled.rotation.m[4] = -1.01;
    lost.translation.y = std::numeric_limits<double>::infinity();
    for (const CameraPose& wrong : {mirrored, scaled, lost}) EXPECT_NE(findProblem(wrong), "");
}

TEST(CameraPose, MarkerAndSceneAreOneSpace) {
    EXPECT_EQ(scenePoint({1, 2, 3}, 0.5), (Vec3d{2, 6, -4}));
    EXPECT_EQ(markerPoint(scenePoint({1, 2, 3}, 0.5), 0.5), (Vec3d{1, 2, 3}));
    EXPECT_EQ(markerDirection({0, 1, 0}), (Vec3d{0, 0, 1}));  // up is out of the paper
}

TEST(CameraResponse, KnownCurvesMeetTheirStandards) {
    ASSERT_TRUE(knownResponse("srgb") && knownResponse("linear") && knownResponse("rec709"));
    EXPECT_FALSE(knownResponse("film"));
    const CameraResponse srgb = *knownResponse("srgb");
    EXPECT_NEAR(exposureOf(srgb, 1, 188), 0.5029, 1e-4);  // IEC 61966-2-1
    EXPECT_NEAR(exposureOf(*knownResponse("rec709"), 0, 127.5f), 0.2596, 1e-4);
    EXPECT_NEAR(exposureOf(*knownResponse("linear"), 2, 51), 0.2, 1e-7);
}

TEST(CameraResponse, CodesComeBack) {
    for (const char* name : {"srgb", "linear", "rec709"}) {
        const CameraResponse response = *knownResponse(name);
        for (float code : {0.0f, 0.5f, 3.0f, 100.25f, 254.0f, 255.0f})
            EXPECT_NEAR(codeOf(response, 0, exposureOf(response, 0, code)), code, 2e-3) << name;
        EXPECT_EQ(codeOf(response, 0, -1), 0);
        EXPECT_EQ(codeOf(response, 0, 2), 255);
    }
}

}  // namespace
}  // namespace penumbra::test_pinhole_camera
