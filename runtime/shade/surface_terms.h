#pragma once
// The terms of a vertex that a fragment joins with its pictures: D, then what normal maps need, then A and B at each
// roughness (formats/common/surface.h; docs/formulas.md, section 18).
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/material_tables.h"

namespace penumbra {

struct SurfaceTerms {
    // 3 where some slot has a normal map: of each colour the vector W, along the surface, that gives a normal n the
    // radiance n . W + (n . vertex normal) D, in the frame of the vertices' normals.
    std::size_t slopes = 0;
    std::size_t steps = 0;  // most roughnesses of a slot
    std::size_t count() const { return 1 + slopes + 2 * steps; }
};
SurfaceTerms surfaceTermsOf(const SurfaceView& surface);

constexpr std::size_t kSlopeAxes = 2;
// The slices of a material that reflects s_x / pi (axis 0) or s_y / pi (1) of the light from above, s in the local
// frame. A surface of the normal n then reflects n_x X + n_y Y + n_z D where it is white and nearly level: to first
// order in its slope.
std::vector<float> slopeSlices(const Convention& convention, int axis);
// Returns that material; `slices` outlive it.
MaterialView slopeMaterial(const Convention& convention, std::span<const float> slices);
MaterialTables slopeTables(const Convention& convention, int light_order, int axis);

}  // namespace penumbra
