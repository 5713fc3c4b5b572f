#pragma once
// Measures diffuse transfer by ray tracing (section "Light that bounces" of docs/formulas.md). The direct transfer of
// a point is t0_i = integral over s.N >= 0 of V(s) (s.N) y_i(s) ds. Each further bounce is a product with a sparse
// matrix, whose rows the same rays give.
#include "bake/trace/moments.h"

namespace penumbra {

// One row of the bounce matrix: how much light a point gets from each vertex that its rays see. Vertex q with the
// outgoing transfer x_q sends weight * x_q.
struct BounceEntry {
    std::uint32_t vertex = 0;
    float weight = 0;  // sum over the hits of 4 cos / directions * barycentric coordinate: (1 / pi) d omega cos
};
using BounceRow = std::vector<BounceEntry>;

struct TransferOutput {
    std::span<float> direct;    // [points][n^2] t0
    std::span<BounceRow> rows;  // [points]; empty: no bounces
};

// How many rays were traced, how many of them hit a surface, and how many of these hits were backs that reflect
// nothing.
struct RayCounts {
    std::size_t traced = 0, hits = 0, backs = 0;
};

// Writes the direct transfer and the bounce row of each point. The points are the vertices `first_vertex`,
// `first_vertex` + 1, ... of tracer.mesh, and the rays are those that traceMoments() traces. A hit on the back of a
// one-sided mesh and one on an occluder block light and reflect none. A hit on a two-sided mesh, or on
// a triangle with a twin, counts for the vertices of the side that was hit. May be called from many threads; a point's
// result depends on that point alone.
RayCounts traceTransfer(const MomentTracer& tracer, std::span<const Vec3> positions, std::span<const Vec3> normals,
                        const TransferOutput& out, std::size_t first_vertex);

// Computes the next bounce of some points: out[p] = sum over the entries of row p of weight * outgoing[vertex]. Each
// vertex and each point has `size` numbers. The sums run in the order of the entries.
void bounce(std::span<const BounceRow> rows, std::span<const float> outgoing, std::size_t size, std::span<float> out);

}  // namespace penumbra
