#include <gtest/gtest.h>

#include <stdexcept>

#include "sh/camera.h"
#include "sh/light/light_rotation.h"

namespace penumbra::test_light_rotation {
namespace {

void expectNear(Vec3d a, Vec3d b) { EXPECT_LT(length(a - b), 1e-12); }

TEST(LightRotation, QuarterTurnsGoTheWayThatIsWritten) {
    expectNear(parseLightRotation("yaw=90") * Vec3d{0, 0, 1}, {1, 0, 0});
    expectNear(parseLightRotation("pitch=90") * Vec3d{0, 0, 1}, {0, 1, 0});
    expectNear(parseLightRotation("roll=90") * Vec3d{1, 0, 0}, {0, 1, 0});
    expectNear(parseLightRotation("axis=0/3/0,angle=90") * Vec3d{0, 0, 1}, {1, 0, 0});
    EXPECT_EQ(parseLightRotation(""), Mat3d());
}

// A point at +z goes to where a camera of the same yaw and pitch stands.
TEST(LightRotation, TurnsAsACameraMoves) {
    const Camera camera = makeCamera("yaw=37,pitch=21,distance=1,target=0/0/0", {}, 1);
    expectNear(parseLightRotation("yaw=37,pitch=21") * Vec3d{0, 0, 1}, cameraPosition(camera));
}

TEST(LightRotation, IsARotation) {
    for (const char* text : {"yaw=10,pitch=-70,roll=200", "axis=1/2/-0.5,angle=77", "roll=-5"}) {
        const Mat3d r = parseLightRotation(text), product = r * transposed(r);
        for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(product.m[i], i % 4 == 0 ? 1 : 0, 1e-12) << text;
        expectNear(cross(r * Vec3d{1, 0, 0}, r * Vec3d{0, 1, 0}), r * Vec3d{0, 0, 1});
    }
    // Three steps about this axis make a whole turn.
    const Mat3d third = parseLightRotation("axis=1/1/1,angle=120");
    expectNear(third * Vec3d{1, 0, 0}, {0, 1, 0});
}

TEST(LightRotation, RefusesWhatItCannotRead) {
    for (const char* text : {"yaw", "yaw=361", "tilt=3", "axis=0/0/0,angle=3", "axis=1/0/0", "angle=3",
                             "axis=1/0/0,angle=3,yaw=1", "yaw=1,yaw=2", "axis=1/0,angle=3", "yaw=nan"})
        EXPECT_THROW(parseLightRotation(text), std::invalid_argument) << text;
}

}  // namespace
}  // namespace penumbra::test_light_rotation
