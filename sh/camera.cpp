#include "sh/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sh/angles.h"
#include "sh/bounding_box.h"
#include "sh/key_values.h"

namespace penumbra {

double defaultPitch(std::span<const Vec3> rest_positions) {
    const BoundingBox box = boundsOf(rest_positions);
    const Vec3d size = toDouble(box.high) - toDouble(box.low);
    const double width = std::min(size.x, size.z);
    return width > 0 ? radians(35) * std::clamp(2 - 8 * size.y / width, 0.0, 1.0) : 0;
}

Camera makeCamera(std::string_view text, std::span<const Vec3> positions, double radius, double pitch, Vec3d origin) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const BoundingBox box = boundsOf(positions);
    Camera camera{.target = (toDouble(box.low) + toDouble(box.high)) * 0.5,
                  .pitch = pitch,
                  .distance = nan,
                  .vertical_fov = radians(35)};
    for (const KeyValue& item : splitKeyValues(text)) {
        if (item.key == "yaw")
            camera.yaw = radians(parseNumber("camera yaw", item.value, -360, 360));
        else if (item.key == "pitch")
            camera.pitch = radians(parseNumber("camera pitch", item.value, -89, 89));
        else if (item.key == "fov")
            camera.vertical_fov = radians(parseNumber("camera fov", item.value, 1, 170));
        else if (item.key == "distance")
            camera.distance = parseNumber("camera distance", item.value, 1e-9, 1e9);
        else if (item.key == "target")
            camera.target = parseTriple("camera target", item.value, -1e9, 1e9) - origin;
        else
            throw std::invalid_argument("camera has no '" + std::string(item.key) +
                                        "': use yaw, pitch, fov, distance, target");
    }
    if (std::isnan(camera.distance)) camera.distance = std::max(radius, 1e-9) / std::sin(camera.vertical_fov / 2);
    return camera;
}

namespace {

struct Axes {
    Vec3d right, up, forward;
};

Axes axesOf(const Camera& camera) {
    const double sy = std::sin(camera.yaw), cy = std::cos(camera.yaw), sp = std::sin(camera.pitch),
                 cp = std::cos(camera.pitch);
    return {{cy, 0, -sy}, {-sp * sy, cp, -sp * cy}, {-cp * sy, -sp, -cp * cy}};
}

}  // namespace

Vec3d cameraPosition(const Camera& camera) { return camera.target - axesOf(camera).forward * camera.distance; }

Vec3d pixelDirection(const Camera& camera, double x, double y, int width, int height) {
    const Axes axes = axesOf(camera);
    const double half = std::tan(camera.vertical_fov / 2);
    const double u = (2 * x / width - 1) * half * width / height, v = (1 - 2 * y / height) * half;
    return normalized(axes.forward + axes.right * u + axes.up * v);
}

void clipFromModel(const Camera& camera, double aspect, double radius, std::span<float, 16> out) {
    const Axes axes = axesOf(camera);
    const Vec3d eye = cameraPosition(camera);
    // Four radii leave room for a target far from the model's center.
    const double far = camera.distance + 4 * radius;
    const double near = std::max(camera.distance - 4 * radius, 1e-3 * std::min(camera.distance, far));
    const double fy = 1 / std::tan(camera.vertical_fov / 2), fx = fy / aspect;
    const double depth_scale = (far + near) / (far - near), depth_offset = -2 * far * near / (far - near);
    const auto row = [&](int index, Vec3d axis, double scale, double offset) {
        for (int column = 0; column < 3; ++column) out[4 * column + index] = float(axis[column] * scale);
        out[12 + index] = float(-dot(axis, eye) * scale + offset);
    };
    row(0, axes.right, fx, 0);
    row(1, axes.up, fy, 0);
    row(2, axes.forward, depth_scale, depth_offset);
    row(3, axes.forward, 1, 0);
}

}  // namespace penumbra
