#pragma once
// A height field in a scene, whose y is up: its columns go along x, its rows along z, its heights along y.
#include <span>

#include "sh/height/height_field.h"

namespace penumbra {

// Returns y of the field at a place of the scene, on its triangles. `corner` is where height 0 of row 0 and column 0
// stands.
double heightOfField(const HeightField& field, Vec3d corner, double x, double z);

// Returns y of the ground that something stands on, whose points are `pose` in a frame of its own. It stands on what is
// lowest of it: the ground is averaged over the places of all points, and a point that is h above the lowest one has
// the weight (1 - h / s)^2, up to s = kStandingShare of the diagonal of the pose's box. So the ground changes without a
// jump from the foot that leaves it to the foot that lands, and in the air it is that below both. Without points it is
// the ground at the place of `to_scene`.
constexpr float kStandingShare = 0.2f;
double groundUnderPose(const HeightField& field, Vec3d corner, std::span<const Vec3> pose, const Affine& to_scene);

}  // namespace penumbra
