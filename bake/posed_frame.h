#pragma once
// Prepares one frame of a bake for tracing.
#include "bake/bake_visibility.h"
#include "bake/moments.h"

namespace penumbra {

constexpr std::size_t kVerticesPerTask = 64;  // 5 ms of rays at the defaults: 8 threads stay busy on small meshes

// Poses the vertices of a frame. Its coefficients have their size but are not traced yet. Throws InvalidInput when a
// vertex is not finite.
VisibilityFrame poseVertices(const BakePlan& plan, std::size_t frame);

// A posed frame with its acceleration structure.
struct PosedFrame {
    VisibilityFrame frame;
    SceneScale scale;
    OcclusionScene scene;
};
PosedFrame poseFrame(const BakePlan& plan, std::size_t frame);

// Returns a tracer of that frame, which refers to all three arguments.
MomentTracer tracerOf(const BakePlan& plan, const PosedFrame& posed, const RayDirections& directions);

}  // namespace penumbra
