#include <numbers>
#include <stdexcept>

#include "sh/camera.h"
#include "tests/sh/golden.h"

namespace penumbra::test_camera {
namespace {

const std::vector<Vec3> kBox = {{-1, 0, -2}, {3, 4, 2}};

TEST(Camera, FramesWhatIsNotGiven) {
    const Camera camera = makeCamera("", kBox, 2);
    EXPECT_EQ(camera.target, (Vec3d{1, 2, 0}));
    // The sphere touches the upper edge of the frame: sin(fov/2) = radius / distance.
    EXPECT_NEAR(camera.distance * std::sin(camera.vertical_fov / 2), 2, 1e-12);
    EXPECT_LT(length(cameraPosition(camera) - Vec3d{1, 2, camera.distance}), 1e-12);  // at +z
}

TEST(Camera, ReadsEveryKey) {
    const Camera camera = makeCamera("yaw=90,pitch=30,fov=60,distance=5,target=1/2/3", kBox, 2);
    EXPECT_NEAR(camera.vertical_fov, std::numbers::pi / 3, 1e-12);
    const double c = std::sqrt(0.75);
    EXPECT_LT(length(cameraPosition(camera) - Vec3d{1 + 5 * c, 2 + 2.5, 3}), 1e-12);  // towards +x and up
    for (const char* text : {"yaw", "yaw=", "roll=1", "yaw=1,yaw=2", "fov=0", "fov=180", "pitch=90", "distance=0",
                             "distance=inf", "target=1/2", "yaw=30;pitch=2"})
        EXPECT_THROW(makeCamera(text, kBox, 2), std::invalid_argument) << text;
}

// Boxes of width x height x depth. Upright ones are seen level: a character (also a low one), a curtain, a ribbon.
TEST(Camera, FlatSheetsAreSeenFromAbove) {
    const auto degrees = [](float width, float height, float depth) {
        return defaultPitch(std::vector<Vec3>{{1, 2, 3}, {1 + width, 2 + height, 3 + depth}}) * 180 / std::numbers::pi;
    };
    for (const Vec3& size : {Vec3{1.8f, 1.8f, 0.3f}, {0.5f, 0.2f, 2}, {2, 2, 0}, {2, 0.1f, 0}, {0, 0, 0}, {4, 1, 4}})
        EXPECT_EQ(degrees(size.x, size.y, size.z), 0) << size.x << ' ' << size.y << ' ' << size.z;
    EXPECT_NEAR(degrees(2, 0, 3), 35, 1e-5);
    EXPECT_NEAR(degrees(3, 0.25f, 2), 35, 1e-5);
    EXPECT_NEAR(degrees(2, 0.375f, 2), 17.5, 1e-5);
    EXPECT_NEAR(degrees(2, 0.499f, 2), 0, 0.2);
    EXPECT_EQ(defaultPitch({}), 0);
    EXPECT_EQ(makeCamera("", kBox, 2, 0.5).pitch, 0.5);
    EXPECT_EQ(makeCamera("pitch=0", kBox, 2, 0.5).pitch, 0);
}

TEST(Camera, PixelsAndClipSpaceAgree) {
    const Camera camera = makeCamera("yaw=40,pitch=-20,fov=50,target=0.5/1/0", kBox, 2);
    const int width = 320, height = 200;
    std::array<float, 16> m;
    clipFromModel(camera, double(width) / height, 2, m);
    for (double x : {0.5, 100.0, 319.5})
        for (double y : {0.5, 77.0, 199.5})
            for (double t : {0.6, 1.0, 1.4}) {
                const Vec3d p =
                    cameraPosition(camera) + pixelDirection(camera, x, y, width, height) * (camera.distance * t);
                const auto row = [&](int i) { return m[i] * p.x + m[4 + i] * p.y + m[8 + i] * p.z + m[12 + i]; };
                EXPECT_NEAR(row(0) / row(3), 2 * x / width - 1, 1e-5);
                EXPECT_NEAR(row(1) / row(3), 1 - 2 * y / height, 1e-5);
                EXPECT_GT(row(3), 0);
                EXPECT_LE(std::abs(row(2)), row(3));
            }
}

// The model's sphere is not clipped, and neither is as much again in front of it and behind it. Depth is -1 at the near
// plane and 1 at the far plane.
TEST(Camera, DepthSpansTheModel) {
    for (const char* text : {"", "distance=40", "distance=0.5"}) {
        const Camera camera = makeCamera(text, kBox, 2);
        std::array<float, 16> m;
        clipFromModel(camera, 1, 2, m);
        const auto depth = [&](double distance) {  // depth of the point at this distance in front of the camera
            const Vec3d p = cameraPosition(camera) + pixelDirection(camera, 0.5, 0.5, 1, 1) * distance;
            return (m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]) / (m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15]);
        };
        const double far = camera.distance + 8, near = std::max(camera.distance - 8, 1e-3 * camera.distance);
        EXPECT_NEAR(depth(near), -1, 1e-3) << text;
        EXPECT_NEAR(depth(far), 1, 1e-5) << text;
        EXPECT_LT(depth(camera.distance), depth(camera.distance + 1)) << text;
    }
}

}  // namespace
}  // namespace penumbra::test_camera
