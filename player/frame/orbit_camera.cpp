#include "player/frame/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sh/angles.h"

namespace penumbra {

constexpr double kPi = std::numbers::pi;
constexpr double kMaxPitch = radians(89);  // same limit as in makeCamera()

void frameAll(Camera& camera, const BoundingBox& box, double aspect) {
    camera.target = toDouble(box.low + box.high) * 0.5;
    const double half = std::atan(std::tan(camera.vertical_fov / 2) * std::min(1.0, aspect));
    camera.distance = std::max(box.radius(), 1e-9) / std::sin(half);
}

void orbit(Camera& camera, double right, double down, double height) {
    camera.yaw = std::remainder(camera.yaw - kPi * right / height, 2 * kPi);
    camera.pitch = std::clamp(camera.pitch + kPi * down / height, -kMaxPitch, kMaxPitch);
}

void pan(Camera& camera, double right, double down, double height) {
    // size of a pixel
    const double size = 2 * camera.distance * std::tan(camera.vertical_fov / 2) / height;
    const Vec3d right_axis{std::cos(camera.yaw), 0, -std::sin(camera.yaw)};
    const Vec3d backward = normalized(cameraPosition(camera) - camera.target);
    camera.target += right_axis * (-right * size) + cross(backward, right_axis) * (down * size);
}

void dolly(Camera& camera, double steps, double radius) {
    const double scale = std::max(radius, 1e-9);
    camera.distance = std::clamp(camera.distance * std::pow(0.9, steps), 0.02 * scale, 100 * scale);
}

void turntable(Camera& camera, double seconds) {
    camera.yaw = std::remainder(camera.yaw + 2 * kPi * seconds / kTurnSeconds, 2 * kPi);
}

}  // namespace penumbra
