#pragma once
// Finds the thing under the pointer, and changes a ground with heights there.
#include <optional>

#include "player/view/view_layout.h"

namespace penumbra {

// Returns the corner nearest to the hit of the triangle that a ray meets first. `direction` need not be unit. Both
// sides of triangles count, but only the front in a two-sided mesh, so that the side that is seen is picked.
std::optional<std::size_t> pickVertex(std::span<const Vec3> positions, const MeshView& mesh, Vec3d origin,
                                      Vec3d direction, double& distance);

// Returns the vertex under (x, y), in the coordinates of `picture`, of what was drawn last.
std::optional<PickedVertex> pick(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                 double y);

// Returns where the pointer's ray meets the height, in the scene; nothing above the horizon or too far away to say.
std::optional<Vec3d> pointAtHeight(const ViewState& state, double height, const Rectangle& picture, double x, double y);

// Returns where a ray meets the field from above, nothing where it misses it. `way` need not be unit.
std::optional<Vec3d> pointOnField(const GroundHeights& heights, Vec3d origin, Vec3d way);
// Returns what the brush does in so many seconds, which are below 0 where it lowers, under the pointer, in the
// coordinates of `picture`. Nothing where the pointer is beside the field.
std::optional<GroundStroke> strokeUnder(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                        double y, double seconds);

}  // namespace penumbra
