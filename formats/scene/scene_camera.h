#pragma once
// The camera of a photograph in the frame of a scene: where a point of the scene appears, and what a pixel sees.
#include <array>
#include <span>
#include <vector>

#include "formats/scene/scene_file.h"
#include "sh/camera.h"

namespace penumbra {

// The camera of one picture, in the scene whose places count from SceneDescription::origin.
struct SceneView {
    PinholeCamera camera;
    CameraPose pose;
    double world_scale = 1;
    Vec3d origin;

    Vec3d eye() const;
    // From the scene's directions to those of the camera, x right, y down, z forward.
    Mat3d turn() const;
    // A point of the scene in the camera's frame, in metres of the scene.
    Vec3d inCamera(Vec3d point) const { return turn() * (point - eye()); }
    // Unit direction in the scene that a pixel sees.
    Vec3d direction(PixelPoint pixel) const { return transposed(turn()) * viewRay(camera, pixel); }
};

// Writes the column-major matrix for GL of a camera without its lens, for a picture of the camera's size. Depths lie
// between near and far, 0 < near < far, in metres of the scene.
void clipFromScene(const SceneView& view, double near, double far, std::span<float, 16> out);

// The camera of a window that stands where the view does and looks alike, about a point `distance` metres away. A roll,
// the principal point and the lens are lost.
Camera orbitLike(const SceneView& view, double distance);

// All pictures that a scene's camera took.
class SceneCameras {
public:
    // Reads the file of poses, if there is one. Throws what its reader throws, and InvalidInput where the first frame
    // is not there. The scene has a photograph.
    explicit SceneCameras(const SceneDescription& scene);
    // How many pictures there are from the first one on; 1 where the camera stands still.
    std::size_t count() const { return poses_.size(); }
    bool moves() const { return moves_; }
    // Names of the pictures' files, as in the poses; "" of a picture without a name.
    const std::vector<std::string>& files() const { return files_; }
    // Tells whether view() knows a pose of this picture, of which a camera that stands still has every one.
    bool hasPose(std::size_t picture) const;
    const PinholeCamera& camera() const { return view_.camera; }
    // Throws InvalidInput, which names the frame, where it is not there or has no pose. A camera that stands still has
    // every picture. `origin` is that of the scene.
    SceneView view(std::size_t picture, Vec3d origin) const;
    // The same camera where it stands elsewhere.
    SceneView viewFrom(const CameraPose& pose, Vec3d origin) const;

private:
    SceneView view_;  // without a pose
    std::string at_;
    std::size_t first_ = 0;
    bool moves_ = false;
    std::vector<std::optional<CameraPose>> poses_;
    std::vector<std::string> files_;  // one of each pose
};

}  // namespace penumbra
