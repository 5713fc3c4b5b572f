#pragma once
// Where the rays of a point of a sheet start, so that they neither jump over a surface that lies on the sheet nor stay
// inside a body that the sheet has sunk into.
//
// A search ray to the point's own side (along the normal, but see vertex_side.h) meets the surfaces near it; the
// point's own triangles do not count. Distances are in rest diagonals.
//   1. Rays start at the bias, but at most half-way to the first surface: nothing lies between the point and the start.
//   2. Sunk in: a first surface within kSunkIn that is the back of a solid (a closed surface that the point is no part
//      of) is left: the rays start beyond it, by rule 1 from there. Only on the side whose way out is the shorter: a
//      sheet that has sunk into a thin plate comes out at one side of it.
//   3. Touching: a surface within kTouching of the point, on either side of it, is looked at by its normal, as numbers
//      this small say nothing else: when its front faces the rays, the two touch and no ray escapes; when its back
//      does, the point lies on it and it is left out.
#include "bake/blockers.h"
#include "bake/occlusion.h"

namespace penumbra {

constexpr float kSunkIn = 0.01f;
constexpr float kTouching = 1e-6f;  // 16 steps of a float at the model's rim

// In the ray tracer's frame.
struct StartOfSurface {
    Vec3 position;
    Vec3 direction;          // unit, to the side that the rays leave
    float bias = 0;          // from the position to the start where nothing is near
    Triangle own{};          // triangles with any of these vertices do not count
    std::int32_t solid = 0;  // that the point is part of
};
struct RayStart {
    Vec3 position;
    bool closed = false;  // rule 3: no ray escapes
};
RayStart startOfRays(const OcclusionScene& scene, const Blockers& blockers, const StartOfSurface& from);

}  // namespace penumbra
