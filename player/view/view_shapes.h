#pragma once
// Surfaces that are drawn beside the characters, and what their vertices show. No GL.
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/frame/orbit_camera.h"

namespace penumbra {

struct Shape {
    std::vector<Vec3> positions, values;  // linear colours
    std::vector<std::uint32_t> triangles;
};

// Radius 1 about the origin: `rings` quads from pole to pole, twice as many around. Its positions are directions.
Shape unitSphere(int rings);

// Radiance that comes from each direction of a light that is turned by `rotation`, L(R^T s); ringing below 0 as 0.
std::vector<Vec3> radianceFrom(const LightView& light, const Mat3& rotation, std::span<const Vec3> directions);
// Of a horizontal plane that sees the whole upper half: the integral of L cos over it.
Vec3 irradianceFromAbove(const LightView& light, const Mat3& rotation);

// A chequered square at the height of the box' floor, tiles of a third of the box' radius. Values: `light` (radiance of
// a white plane) times the tiles' albedo.
Shape groundPlane(const BoundingBox& box, Vec3 light);

}  // namespace penumbra
