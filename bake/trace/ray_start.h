#pragma once
// Decides where the rays of a point start. Over the surface of a solid they start at the bias along the normal. Over a
// sheet, three rules let them neither jump over a surface that lies on the sheet nor stay inside a body that the sheet
// has sunk into. ray_start.cpp explains why.
//
// A search ray to the point's own side (along the normal, with the exceptions of vertex_side.h) meets the surfaces
// near it. The triangles around the point itself do not count. Distances are in rest diagonals.
//   1. Rays start at the bias, but at most half-way to the first surface: nothing lies between the point and the start.
//   2. Sunk in: the sheet may have sunk into a solid, a closed surface that the point is no part of. Then the
//      first surface within kSunkIn is the back of that solid. The rays start beyond it, and rule 1 applies from there.
//      This applies only to the side from which the shorter way leads out of the solid: a sheet in a thin plate comes
//      out on one side.
//   3. Touching: a distance up to kTouching, to either side of the point, may be rounding, so the surface's
//      normal decides. If its front faces the rays, the two surfaces touch and no ray escapes. If its back does, the
//      point lies on the surface, and the search leaves it out.
#include "bake/trace/blockers.h"
#include "bake/trace/occlusion.h"

namespace penumbra {

constexpr float kSunkIn = 0.01f;
constexpr float kTouching = 1e-6f;  // 16 steps of a float at the model's rim

// All values are in the frame of the ray tracer (SceneScale of occlusion.h).
struct StartOfSurface {
    Vec3 position;
    Vec3 direction;          // unit, to the side that the rays leave
    float bias = 0;          // distance from the position to the start where nothing is near
    Triangle own{};          // triangles with any of these vertices do not count
    std::int32_t solid = 0;  // the closed surface that the point is part of; 0 = none
};
struct RayStart {
    Vec3 position;
    bool closed = false;         // rule 3: no ray escapes
    std::uint32_t touching = 0;  // the triangle that closes the point
};
// The start over a solid: `bias` along the unit normal.
inline RayStart startOverSolid(Vec3 position, Vec3 normal, float bias) { return {position + normal * bias}; }
// The start over a sheet, by the three rules.
RayStart startOverSheet(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& from);

}  // namespace penumbra
