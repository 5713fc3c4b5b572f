#pragma once
// Areas of silhouettes: what a mesh, or a set of spheres, covers of a plane that it is projected on along parallel
// rays.
#include <span>
#include <vector>

#include "formats/common/mesh.h"
#include "sh/caster_sphere.h"

namespace penumbra {

// Lines that cross a silhouette. What lies between two lines is missed or counted whole, so the area of a disc as high
// as the silhouette is within 2e-4.
constexpr int kSilhouetteRows = 256;

// Returns `count` unit directions spread evenly over half of the sphere: the silhouette from the other side has the
// same area.
std::vector<Vec3d> silhouetteViews(int count);

// Return the area that is covered as seen along a view (a unit vector), in squares of the unit of the positions.
double silhouetteArea(std::span<const CasterSphere> spheres, Vec3d view);
double silhouetteArea(std::span<const Triangle> triangles, std::span<const Vec3> positions, Vec3d view);

}  // namespace penumbra
