// Bounces light between the vertices of a frame (section "Light that bounces" of docs/formulas.md).
//
// With the bounce matrix M of the frame and the outgoing transfer x = albedo t0 of each vertex and colour channel, one
// bounce is t1 = M x, the next one is t2 = M (albedo t1), and so on. On a membrane the light that comes through from
// the other side joins the outgoing transfer: x_q = albedo_q t_q + transmission_q t_back(q).
#include "bake/visibility/bake_transfer.h"

#include <algorithm>

#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kVerticesOfBounce = 64;  // of one task

// Calls `run(begin, end)` for blocks of vertices, in many threads.
template <class Run>
void forVertices(std::size_t vertices, int threads, const Run& run) {
    parallelFor((vertices + kVerticesOfBounce - 1) / kVerticesOfBounce, threads, [&](std::size_t task) {
        throwIfInterrupted();
        run(task * kVerticesOfBounce, std::min(vertices, (task + 1) * kVerticesOfBounce));
    });
}

// Returns the vertex on the other side of a two-sided mesh.
std::size_t otherSide(std::size_t vertex, std::size_t vertices) { return (vertex + vertices / 2) % vertices; }

// Computes the outgoing transfer of one vertex from the transfer t [V][3][n2] that reached the surface.
void outgoingOf(const SurfaceColors& colors, std::span<const float> t, std::size_t n2, std::size_t v,
                std::span<float> out) {
    const std::size_t vertices = colors.albedo.size();
    for (std::size_t c = 0; c < 3; ++c) {
        const float albedo = colors.albedo[v][int(c)];
        for (std::size_t i = 0; i < n2; ++i) out[c * n2 + i] = albedo * t[(3 * v + c) * n2 + i];
        if (colors.transmission.empty()) continue;
        const float through = colors.transmission[v][int(c)];
        const std::size_t other = otherSide(v, vertices);
        for (std::size_t i = 0; i < n2; ++i) out[c * n2 + i] += through * t[(3 * other + c) * n2 + i];
    }
}

// The direct transfer, once for each colour channel.
std::vector<float> inThreeChannels(std::span<const float> direct, std::size_t n2) {
    std::vector<float> out;
    out.reserve(3 * direct.size());
    for (std::size_t at = 0; at < direct.size(); at += n2)
        for (int c = 0; c < 3; ++c)
            out.insert(out.end(), direct.begin() + std::ptrdiff_t(at), direct.begin() + std::ptrdiff_t(at + n2));
    return out;
}

}  // namespace

void FrameBounces::add(const RayCounts& counts) {
    traced += counts.traced;
    hits += counts.hits;
    backs += counts.backs;
}

std::size_t traceVertices(const TracedFrame& traced, std::size_t begin, std::size_t size) {
    VisibilityFrame& frame = traced.posed.frame;
    const std::span<const Vec3> positions = std::span(frame.positions).subspan(begin, size),
                                normals = std::span(frame.normals).subspan(begin, size);
    const MomentOutput out = outputOf(frame).part(begin, size, frame.positions.size());
    if (!traced.bounces) return traceMoments(traced.tracer, positions, normals, out, begin);
    std::span<BounceRow> rows = traced.bounces->rows;
    if (!rows.empty()) rows = rows.subspan(begin, size);
    const RayCounts counts = traceTransfer(traced.tracer, positions, normals, {out.coefficients, rows}, begin);
    traced.bounces->add(counts);
    return counts.traced;
}

void addBounces(const VisibilityHeader& header, const FrameBounces& bounces, int threads, VisibilityFrame& frame) {
    const std::size_t vertices = header.mesh.vertexCount(), n2 = header.coefficientCount(), size = 3 * n2;
    std::vector<float> t = inThreeChannels(frame.coefficients, n2), outgoing(t.size());
    std::fill(frame.indirect.begin(), frame.indirect.end(), 0.0f);
    for (int k = 0; k < header.bounces; ++k) {
        forVertices(vertices, threads, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                outgoingOf(header.colors, t, n2, v, std::span(outgoing).subspan(v * size, size));
        });
        forVertices(vertices, threads, [&](std::size_t begin, std::size_t end) {
            const std::span<float> out = std::span(t).subspan(begin * size, (end - begin) * size);
            bounce(std::span(bounces.rows).subspan(begin, end - begin), outgoing, size, out);
            for (std::size_t i = 0; i < out.size(); ++i) frame.indirect[begin * size + i] += out[i];
        });
    }
    const double hits = double(bounces.hits);
    frame.hit_shares = {bounces.traced > 0 ? float(hits / double(bounces.traced)) : 0,
                        bounces.hits > 0 ? float(double(bounces.backs) / hits) : 0};
}

}  // namespace penumbra
