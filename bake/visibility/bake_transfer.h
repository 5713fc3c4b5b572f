#pragma once
// Traces the vertices of one frame of a bake, and bounces light between them.
#include <atomic>

#include "bake/trace/transfer.h"
#include "bake/visibility/frame_scene.h"

namespace penumbra {

// The hits that the rays of a frame found. Many threads fill it, each the rows of its own vertices.
struct FrameBounces {
    std::vector<BounceRow> rows;  // [V]; empty without bounces
    std::atomic<std::size_t> traced = 0, hits = 0, backs = 0;

    explicit FrameBounces(const VisibilityHeader& header) : rows(header.hasBounces() ? header.mesh.vertexCount() : 0) {}
    void add(const RayCounts& counts);
};

// One frame while its vertices are traced.
struct TracedFrame {
    FrameScene& posed;
    const MomentTracer& tracer;
    FrameBounces* bounces;  // null unless transfer is baked
};
// Traces the vertices [begin, begin + size) and returns the number of rays. May be called from many threads.
std::size_t traceVertices(const TracedFrame& traced, std::size_t begin, std::size_t size);

// Computes frame.indirect, the sum of the bounces 1 to header.bounces of frame.coefficients, and frame.hit_shares.
// Gives the same bits for any number of threads. Throws Interrupted.
void addBounces(const VisibilityHeader& header, const FrameBounces& bounces, int threads, VisibilityFrame& frame);

}  // namespace penumbra
