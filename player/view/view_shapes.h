#pragma once
// Surfaces around the characters, under the light of the scene. It uses no GL.
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/frame/orbit_camera.h"
#include "player/frame/shape.h"

namespace penumbra {

// Returns the radiance from each direction of a light that is turned by `rotation`, L(R^T s), with ringing below 0 as
// 0.
std::vector<Vec3> radianceFrom(const LightView& light, const Mat3& rotation, std::span<const Vec3> directions);
// Returns the irradiance of a horizontal plane that sees the whole upper half: the integral of L cos.
Vec3 irradianceFromAbove(const LightView& light, const Mat3& rotation);

// Makes a chequered square at the height of the box' floor, with tiles of a third of the box' radius. Its values are
// `light` (radiance of a white plane) times the tiles' albedo.
Shape groundPlane(const BoundingBox& box, Vec3 light);

}  // namespace penumbra
