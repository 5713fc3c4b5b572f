#pragma once
// Areas of silhouettes: what a mesh, or a set of spheres, covers of a plane that it is projected on along parallel
// rays.
#include <span>
#include <vector>

#include "formats/common/mesh.h"
#include "sh/cast/caster_sphere.h"

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

// The extent of a silhouette across the lines that cross it.
struct SilhouetteRange {
    double low = 0, high = 0;
};
SilhouetteRange rangeOf(std::span<const Vec3> positions, Vec3d view);

// Write the areas that are covered in bands of equal height; what lies outside of the range does not count.
// bands.size() divides kSilhouetteRows.
constexpr std::size_t kSilhouetteBands = 16;
void silhouetteBands(std::span<const CasterSphere> spheres, Vec3d view, SilhouetteRange range, std::span<double> bands);
void silhouetteBands(std::span<const Triangle> triangles, std::span<const Vec3> positions, Vec3d view,
                     SilhouetteRange range, std::span<double> bands);

}  // namespace penumbra
