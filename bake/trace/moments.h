#pragma once
// Measures the hemisphere moments b_i = integral over s.N >= 0 of V(s) y_i(s) ds in the model frame by ray tracing
// (section 2 of docs/formulas.md).
#include "bake/trace/local_parts.h"
#include "bake/trace/ray_reach.h"
#include "bake/trace/ray_start.h"

namespace penumbra {

// Extra inputs for tracing local moments.
struct LocalTracer {
    const LocalParts& parts;
    const RayDirections& directions;          // the same directions, with the basis of the local order
    std::span<const BoundingBox> part_boxes;  // boxes of the parts in this frame, in the space of the scene
};

struct MomentTracer {
    const OcclusionScene& scene;
    const RayDirections& directions;
    SceneScale scale;
    float bias = 1e-4f;          // distance from the surface to the start of a ray, in units of scale.diagonal
    Floor floor = Floor::kNone;  // under every point, at any height
    // Set for sheets, whose rays start by the rules of ray_start.h. If null, rays start at the bias. `mesh` tells
    // which vertex a point is.
    const Blockers* blockers = nullptr;
    const Mesh* mesh = nullptr;
    std::span<const Vec3> vertices = {};  // [V] of the mesh in this frame
    // The vertex of the mesh that each point is; empty: point p is vertex p.
    std::span<const std::uint32_t> vertex_of_point = {};
    // [V] unit, the way from each vertex to the start of its rays over a solid (start_ways.h); empty: the normals.
    std::span<const Vec3> start_ways = {};
    std::optional<LocalTracer> local = {};  // set for local moments; the scene must have been made with `filters`
    // Set where occluders count up to a distance only: the ends of rays, in units of the scene, and the height of a
    // solid floor in the scene, which then counts by its distance, too. Not with local moments.
    const RayReach* reach = nullptr;
    float floor_y = 0;
    std::span<const float> far_bias = {};  // for each front vertex in place of `bias`, where any is far (far_bias.h)

    std::size_t vertexOf(std::size_t point) const { return vertex_of_point.empty() ? point : vertex_of_point[point]; }
};

// Where the moments of some points go.
struct MomentOutput {
    std::span<float> coefficients;  // [points][n^2]
    std::span<float> local = {};    // [points][m^2] with the local order m; empty without local moments

    // The output of the points [begin, begin + count) of `points`.
    MomentOutput part(std::size_t begin, std::size_t count, std::size_t points) const {
        const std::size_t n2 = coefficients.size() / points, m2 = local.size() / points;
        return {coefficients.subspan(begin * n2, count * n2), local.subspan(begin * m2, count * m2)};
    }
};

// Returns the bias of a vertex.
float biasOf(const MomentTracer& tracer, std::size_t vertex);

// Returns where the rays of a point start: at the bias along the normal, or by the rules for sheets where these
// apply. A vertex v of the back has the front vertex v - frontVertexCount().
RayStart startOfVertex(const MomentTracer& tracer, Vec3 position, Vec3 normal, std::size_t vertex);

// Writes the moments of each point and returns the number of rays traced, each counted once. A point whose normal is
// zero has no horizon and gets zeros. With blockers, start ways or local moments the points are the vertices that
// vertexOf() gives for `first_vertex`, `first_vertex` + 1, ... May be called from many threads; a point's result
// depends on that point alone.
std::size_t traceMoments(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const MomentOutput& out, std::size_t first_vertex = 0);

}  // namespace penumbra
