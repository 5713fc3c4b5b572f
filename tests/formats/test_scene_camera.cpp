#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "formats/common/errors.h"
#include "formats/scene/scene_camera.h"
#include "formats/scene/scene_placement.h"
#include "tests/difference.h"

namespace penumbra::test_scene_camera {
namespace {

// A camera 4 m in front of the marker and 2 m above, that looks at it.
const char* const kCamera = R"({"f": 600, "cx": 300, "cy": 250, "size": [640, 480], "k1": -0.1,
    "R": [[1, 0, 0], [0, -0.447213595, -0.894427191], [0, 0.894427191, -0.447213595]], "t": [0, 0, 4.47213595]})";

SceneDescription sceneWith(const std::string& keys) {
    return parseScene(R"({"version": 1, )" + keys + "}", "s.json", testing::TempDir());
}

SceneView viewOf(const std::string& scale, Vec3d origin = {}) {
    return SceneCameras(sceneWith(R"("camera": )" + std::string(kCamera) + R"(, "world_scale": )" + scale))
        .view(0, origin);
}

TEST(SceneCamera, EyeStandsInTheSceneAsTheMarkerSays) {
    // -R^T t = (0, -4, 2) in the marker's frame; the scene has y up, and a tenth of the scale is ten times as far.
    EXPECT_LT(length(viewOf("1").eye() - Vec3d{0, 2, 4}), 1e-6);
    EXPECT_LT(length(viewOf("0.1", {1, 0, 0}).eye() - Vec3d{19, 20, 40} + Vec3d{20, 0, 0}), 1e-5);
}

// GL draws a point where a camera without a lens sees it.
TEST(SceneCamera, MatrixProjectsAsThePinholeDoes) {
    SceneView view = viewOf("0.5", {1024, 0, 0});
    view.camera.k1 = 0;
    std::array<float, 16> m;
    clipFromScene(view, 0.5, 50, m);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-1, 1);
    Largest apart, off_ray;
    for (int i = 0; i < 100; ++i) {
        const Vec3d p = Vec3d{place(random), place(random), place(random)} - view.origin;
        const auto row = [&](int r) {
            return double(m[std::size_t(r)]) * p.x + double(m[std::size_t(4 + r)]) * p.y +
                   double(m[std::size_t(8 + r)]) * p.z + double(m[std::size_t(12 + r)]);
        };
        const std::optional<PixelPoint> seen = project(view.camera, view.inCamera(p));
        ASSERT_TRUE(seen);
        apart.add(std::abs((row(0) / row(3) + 1) * 320 - 0.5 - seen->x));
        apart.add(std::abs((1 - row(1) / row(3)) * 240 - 0.5 - seen->y));
        EXPECT_LT(std::abs(row(2)), row(3));
        off_ray.add(length(cross(view.direction(*seen), normalized(p - view.eye()))));
    }
    EXPECT_LT(apart, 0.02);  // floats of a scene that stands a kilometre away
    EXPECT_LT(off_ray, 1e-9);
}

TEST(SceneCamera, WindowStandsAndLooksAlike) {
    const SceneView view = viewOf("1");
    const Camera orbit = orbitLike(view, 3);
    EXPECT_LT(length(cameraPosition(orbit) - view.eye()), 1e-9);
    EXPECT_LT(length(pixelDirection(orbit, 320, 240, 640, 480) - view.direction({300, 250})), 1e-9);
}

TEST(SceneCamera, PosesOfAFileAreCountedFromTheFrame) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "track.poses.json";
    std::ofstream(file) << R"({"format": "penumbra.camera_poses", "camera": {"f": 100, "size": [10, 10]}, "frames": [
        {"file": "a", "R": [[1,0,0],[0,1,0],[0,0,1]], "t": [0,0,1]}, {"file": "b"},
        {"file": "c", "R": [[1,0,0],[0,1,0],[0,0,1]], "t": [0,0,3]}]})";
    const SceneDescription scene = sceneWith(R"("camera": {"poses": "track.poses.json", "frame": 1})");
    EXPECT_EQ(filesNamedIn(scene).size(), 1u);
    const SceneCameras cameras(scene);
    EXPECT_EQ(cameras.count(), 2u);
    EXPECT_TRUE(cameras.moves());
    EXPECT_THROW(cameras.view(0, {}), InvalidInput);  // no pose
    EXPECT_EQ(cameras.view(1, {}).pose.translation, (Vec3d{0, 0, 3}));
    EXPECT_THROW(cameras.view(2, {}), InvalidInput);
    EXPECT_THROW(SceneCameras(sceneWith(R"("camera": {"poses": "track.poses.json", "frame": 3})")), InvalidInput);
}

TEST(SceneCamera, KeysOfPhotographsAreRead) {
    const SceneDescription scene = sceneWith(R"("camera": )" + std::string(kCamera) +
                                             R"(, "ground": {"catcher": true}, "characters": [], "props": [
        {"asset": "a.pnb", "real": true}, {"real": "box.obj", "position": [1, 0, 0]}, {"real": "b.pnb"},
        {"asset": "c.pnb"}])");
    EXPECT_TRUE(scene.ground->catcher);
    ASSERT_EQ(scene.props.size(), 4u);
    EXPECT_TRUE(scene.props[0].real && !isRealMesh(scene.props[0]));
    EXPECT_TRUE(scene.props[1].real && isRealMesh(scene.props[1]));
    EXPECT_TRUE(scene.props[2].real && !isRealMesh(scene.props[2]));
    EXPECT_FALSE(scene.props[3].real);
    EXPECT_EQ(sceneWith(R"("camera": "yaw=3")").camera, "yaw=3");
    EXPECT_THROW(cameraOf(scene, "", {}), InvalidInput);
    EXPECT_NO_THROW(cameraOf(scene, "yaw=3", {}));
}

TEST(SceneCamera, RefusesWhatItDoesNotKnow) {
    for (const char* keys : {R"("camera": {"f": 600, "size": [64, 48]})", R"("camera": {"poses": "p.json", "f": 3})",
                             R"("camera": 3)", R"("world_scale": 0)", R"("ground": {"catcher": 1})",
                             R"("props": [{"asset": "box.obj"}])", R"("props": [{"asset": "a.pnb", "real": "b.pnb"}])",
                             R"("props": [{"real": true}])", R"("characters": [{"asset": "a.pnb", "real": true}])",
                             R"("props": [{"real": "box.glb", "material": "clay"}])",
                             R"("camera": {"f": 600, "size": [64, 48], "R": [[1,0,0],[0,1,0],[0,0,2]], "t": [0,0,0]})"})
        EXPECT_THROW(sceneWith(keys), InvalidInput) << keys;
}

}  // namespace
}  // namespace penumbra::test_scene_camera
