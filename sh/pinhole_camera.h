#pragma once
// A camera that took a picture: a pinhole with OpenCV's radial lens, and where it stood.
//
// Frames: the camera's has x to the right, y down and z forward. The marker's has its origin in the middle of the
// printed tag, x to its right, y to its top, and z out of the paper; lengths are metres of the real world. A pose
// maps one to the other: x_camera = R x_marker + t. The scene's frame (y up) is (x, z, -y) of the marker's, divided by
// `world_scale`, so that a character of 1.8 m stands on a table top at a world_scale of 0.1.
// Pixels: their centers are whole numbers, so the middle of a picture is (width - 1) / 2.
#include <array>
#include <optional>
#include <string>

#include "sh/vec3.h"

namespace penumbra {

// A place in a picture, in pixels.
struct PixelPoint {
    double x = 0, y = 0;
};

struct PinholeCamera {
    double f = 0;           // focal length in pixels, the same along x and y
    double cx = 0, cy = 0;  // principal point in pixels
    int width = 0, height = 0;
    double k1 = 0, k2 = 0;  // radial lens: distorted = undistorted (1 + k1 r^2 + k2 r^4), at z = 1
    bool operator==(const PinholeCamera&) const = default;
};

struct CameraPose {
    Mat3d rotation;     // R, right-handed and orthonormal
    Vec3d translation;  // t in metres
    // Where the camera stands, in the marker's frame: -R^T t.
    Vec3d place() const;
};

// Empty, or one sentence on what cannot be: a size or f of 0, a number that is not finite, or a lens that folds the
// picture (its radius stops growing before the farthest corner).
std::string findProblem(const PinholeCamera& camera);
// Empty, or one sentence: R is no rotation within 1e-3, or a number is not finite.
std::string findProblem(const CameraPose& pose);

// Returns where a point of the camera's frame appears, which may be outside of the picture. None at z <= 0.
std::optional<PixelPoint> project(const PinholeCamera& camera, Vec3d point);
// Returns the unit direction that a pixel sees, in the camera's frame. The lens is inverted by Newton's method to
// 1e-10 of r.
Vec3d viewRay(const PinholeCamera& camera, PixelPoint pixel);

// Between the frames of the marker and of the scene.
constexpr Vec3d sceneDirection(Vec3d marker) { return {marker.x, marker.z, -marker.y}; }
constexpr Vec3d markerDirection(Vec3d scene) { return {scene.x, -scene.z, scene.y}; }
constexpr Vec3d scenePoint(Vec3d marker, double world_scale) { return sceneDirection(marker) / world_scale; }
constexpr Vec3d markerPoint(Vec3d scene, double world_scale) { return markerDirection(scene) * world_scale; }

}  // namespace penumbra
