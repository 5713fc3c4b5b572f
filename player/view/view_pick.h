#pragma once
#include <optional>

#include "player/view/view_layout.h"

namespace penumbra {

// The corner, of the triangle that a ray meets first, that is nearest to where it meets it. `direction` need not be
// unit; both sides of triangles count, of a two-sided mesh the front: that is, the side that is seen is picked.
std::optional<std::size_t> pickVertex(std::span<const Vec3> positions, const MeshView& mesh, Vec3d origin,
                                      Vec3d direction, double& distance);

// The vertex under (x, y), in the coordinates of `picture`; of what was drawn last.
std::optional<PickedVertex> pick(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                 double y);

}  // namespace penumbra
