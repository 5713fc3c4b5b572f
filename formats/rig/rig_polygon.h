#pragma once
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Adds triangles that cover a polygon, in its winding. `corners` index `points`. Fewer than three corners give nothing.
void cutPolygon(std::span<const Vec3> points, std::span<const std::uint32_t> corners, std::vector<Triangle>& out);

}  // namespace penumbra
