#pragma once
// Hemisphere moments b_i = integral over s.N >= 0 of V(s) y_i(s) ds, model frame, by ray tracing.
#include "bake/ray_start.h"

namespace penumbra {

struct MomentTracer {
    const OcclusionScene& scene;
    const RayDirections& directions;
    SceneScale scale;
    float bias = 1e-4f;   // start of a ray above the surface, in scale.diagonal
    bool ground = false;  // directions with y < 0 are blocked wherever the point is: it stands on an infinite floor
    // Of sheets, whose rays start by the rules of ray_start.h; null: at the bias. `mesh` says which vertex a point is.
    const Blockers* blockers = nullptr;
    const Mesh* mesh = nullptr;
    std::span<const Vec3> vertices = {};  // [V] of the mesh in the frame
};

// Moments of each point into coefficients [points][n^2], and the number of rays traced. A point whose normal is zero
// has no horizon and gets zeros. With blockers the points are vertices `first_vertex`, ... of the mesh. Safe to call
// from many threads; a point's result depends on nothing but that point.
std::size_t traceMoments(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         std::span<float> coefficients, std::size_t first_vertex = 0);

}  // namespace penumbra
