#pragma once
// Shapes a ground with heights by hand.
#include "player/view/view_layout.h"

namespace penumbra {

// Returns where a ray meets the field from above, nothing where it misses it. `way` need not be unit.
std::optional<Vec3d> pointOnField(const GroundHeights& heights, Vec3d origin, Vec3d way);
// Returns what the brush does in so many seconds under the pointer, in the coordinates of `picture`. Nothing where the
// pointer is beside the field.
std::optional<GroundStroke> strokeUnder(const Scene& scene, const ViewState& state, const Rectangle& picture, double x,
                                        double y, bool lowers, double seconds);

}  // namespace penumbra
