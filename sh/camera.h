#pragma once
// The camera that the player and the ray-traced reference share, so that their pictures can be laid over each other.
#include <span>
#include <string>
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

// Looks at `target` from distance along the direction given by yaw and pitch; y is up. Pixel (0,0) is the top left one.
struct Camera {
    Vec3d target;
    double yaw = 0;       // radians; 0 looks along -z (the camera stands at +z), positive moves the camera towards +x
    double pitch = 0;     // radians; positive moves the camera up
    double distance = 1;  // model units
    double vertical_fov = 0.6;  // radians
};

// "yaw=30,pitch=10,fov=35,distance=3,target=0/1/0" (degrees; any subset; "" = all defaults). What is not given is
// framed: target = centre of the box of `positions`, distance so that the sphere of radius `radius` around it fills the
// frame, pitch = `pitch` (radians). Throws std::invalid_argument with a sentence.
Camera makeCamera(std::string_view text, std::span<const Vec3> positions, double radius, double pitch = 0);

// The pitch of pictures that are told none: 0, but a sheet that lies flat at rest is seen obliquely from above and not
// on its edge. With r = the box's height / the smaller of its two widths: 35 degrees up to r = 1/8, 0 from r = 1/4 on,
// linear between. Of the rest pose, so that all frames are seen alike.
double defaultPitch(std::span<const Vec3> rest_positions);

Vec3d cameraPosition(const Camera& camera);
// Unit direction through pixel coordinates (x right, y down, pixel centres at +0.5) of a width x height picture.
Vec3d pixelDirection(const Camera& camera, double x, double y, int width, int height);

// Column-major 4x4 for GL: clip = matrix * (position, 1); near and far are chosen from distance and `radius`.
void clipFromModel(const Camera& camera, double aspect, double radius, std::span<float, 16> out);

}  // namespace penumbra
