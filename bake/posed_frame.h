#pragma once
// One frame of a bake, ready to be traced.
#include "bake/bake_visibility.h"
#include "bake/moments.h"

namespace penumbra {

constexpr std::size_t kVerticesPerTask = 64;  // 5 ms of rays at the default: 8 threads stay busy on small meshes

// Posed; the coefficients are there but not traced. InvalidInput when a vertex is not finite.
VisibilityFrame poseVertices(const BakePlan& plan, std::size_t frame);

// With its acceleration structure.
struct PosedFrame {
    VisibilityFrame frame;
    SceneScale scale;
    OcclusionScene scene;
};
PosedFrame poseFrame(const BakePlan& plan, std::size_t frame);

// Of that frame; it refers to all three.
MomentTracer tracerOf(const BakePlan& plan, const PosedFrame& posed, const RayDirections& directions);

}  // namespace penumbra
