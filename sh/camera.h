#pragma once
// The camera that the player and the ray-traced reference share. Their pictures can therefore be laid over each other.
#include <span>
#include <string>
#include <string_view>

#include "sh/vec3.h"

namespace penumbra {

// A camera that looks at `target` from `distance` along the direction that yaw and pitch give. y is up. Pixel (0,0) is
// at the top left.
struct Camera {
    Vec3d target;
    double yaw = 0;       // radians; 0 looks along -z, with the camera at +z; positive moves the camera towards +x
    double pitch = 0;     // radians; positive moves the camera up
    double distance = 1;  // model units
    double vertical_fov = 0.6;  // radians
    bool operator==(const Camera&) const = default;
};

// Parses any subset of "yaw=30,pitch=10,fov=35,distance=3,target=0/1/0", in degrees; "" means all defaults. What is not
// given is framed: `target` becomes the center of the box of `positions`, the distance makes the sphere of radius
// `radius` around it fill the frame, and the pitch is `pitch` (radians). Positions and the result count from `origin`,
// which stands in the frame of a given target. Throws std::invalid_argument with a sentence.
Camera makeCamera(std::string_view text, std::span<const Vec3> positions, double radius, double pitch = 0,
                  Vec3d origin = {});

// Returns the pitch for pictures that are told none. It is 0, except that a sheet which lies flat at rest is seen
// obliquely from above and not on its edge. With r = the box's height / the smaller of its two widths, it is 35 degrees
// up to r = 1/8, 0 from r = 1/4 on, and linear between. It comes from the rest pose, so that all frames are seen alike.
double defaultPitch(std::span<const Vec3> rest_positions);

Vec3d cameraPosition(const Camera& camera);
// Returns the unit direction through pixel coordinates of a width x height picture: x right, y down, pixel centers at
// +0.5.
Vec3d pixelDirection(const Camera& camera, double x, double y, int width, int height);

// Writes the column-major 4x4 matrix for GL, clip = matrix * (position, 1). Near and far are chosen from the distance
// and from `radius`.
void clipFromModel(const Camera& camera, double aspect, double radius, std::span<float, 16> out);

}  // namespace penumbra
