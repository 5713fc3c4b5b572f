#include "formats/scene/scene_camera.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"

namespace penumbra {

Vec3d SceneView::eye() const { return scenePoint(pose.place(), world_scale) - origin; }

Mat3d SceneView::turn() const {
    // Columns: where the scene's axes go, by way of the marker's.
    Mat3d out;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d unit;
        unit[axis] = 1;
        const Vec3d turned = pose.rotation * markerDirection(unit);
        for (int row = 0; row < 3; ++row) out(row, axis) = turned[row];
    }
    return out;
}

void clipFromScene(const SceneView& view, double near, double far, std::span<float, 16> out) {
    const PinholeCamera& camera = view.camera;
    const Mat3d turn = view.turn();
    const Vec3d eye = view.eye();
    const auto axis = [&](int row) { return Vec3d{turn(row, 0), turn(row, 1), turn(row, 2)}; };
    const Vec3d right = axis(0), down = axis(1), forward = axis(2);
    // Pixel (x, y) covers x - 1/2 to x + 1/2, and row 0 is the top one.
    const double across = (2 * camera.cx + 1) / camera.width - 1, up = 1 - (2 * camera.cy + 1) / camera.height;
    const double depth_scale = (far + near) / (far - near), depth_offset = -2 * far * near / (far - near);
    const auto put = [&](int index, Vec3d direction, double offset) {
        for (int column = 0; column < 3; ++column) out[std::size_t(4 * column + index)] = float(direction[column]);
        out[std::size_t(12 + index)] = float(-dot(direction, eye) + offset);
    };
    put(0, right * (2 * camera.f / camera.width) + forward * across, 0);
    put(1, down * (-2 * camera.f / camera.height) + forward * up, 0);
    put(2, forward * depth_scale, depth_offset);
    put(3, forward, 0);
}

Camera orbitLike(const SceneView& view, double distance) {
    const Mat3d turn = view.turn();
    const Vec3d forward{turn(2, 0), turn(2, 1), turn(2, 2)};
    Camera camera;
    camera.pitch = std::asin(std::clamp(-forward.y, -1.0, 1.0));
    camera.yaw = std::atan2(-forward.x, -forward.z);
    camera.distance = distance;
    camera.target = view.eye() + forward * distance;
    camera.vertical_fov = 2 * std::atan(0.5 * view.camera.height / view.camera.f);
    return camera;
}

SceneCameras::SceneCameras(const SceneDescription& scene) {
    const SceneCamera& photograph = *scene.photograph;
    at_ = photograph.at;
    view_.world_scale = scene.world_scale;
    if (photograph.poses.empty()) {
        view_.camera = photograph.camera;
        poses_.emplace_back(photograph.pose);
        files_.emplace_back();
        return;
    }
    const CameraTrack track = readCameraTrack(photograph.poses);
    view_.camera = track.camera;
    first_ = photograph.frame;
    moves_ = true;
    if (first_ >= track.frames.size())
        throw InvalidInput(at_ + "/frame: is " + std::to_string(first_) + ", and " + photograph.poses.string() +
                           " has " + std::to_string(track.frames.size()) + " frames");
    for (std::size_t i = first_; i < track.frames.size(); ++i) {
        poses_.push_back(track.frames[i].pose);
        files_.push_back(track.frames[i].file);
    }
}

bool SceneCameras::hasPose(std::size_t picture) const {
    return !moves_ || (picture < poses_.size() && poses_[picture].has_value());
}

SceneView SceneCameras::view(std::size_t picture, Vec3d origin) const {
    const std::size_t i = moves_ ? picture : 0;
    if (i >= poses_.size())
        throw InvalidInput(at_ + "/poses: has no frame " + std::to_string(first_ + i) + ", the last is " +
                           std::to_string(first_ + poses_.size() - 1));
    if (!poses_[i])
        throw InvalidInput(at_ + "/poses: frame " + std::to_string(first_ + i) + " has no pose" +
                           (files_[i].empty() ? "" : " (" + files_[i] + ")") +
                           "; penumbra-fit poses can fill gaps between two pictures with a tag, and none at the ends");
    return viewFrom(*poses_[i], origin);
}

SceneView SceneCameras::viewFrom(const CameraPose& pose, Vec3d origin) const {
    SceneView out = view_;
    out.pose = pose;
    out.origin = origin;
    return out;
}

}  // namespace penumbra
