#pragma once
// Prepares one frame of a bake for tracing.
#include "bake/trace/moments.h"
#include "bake/visibility/bake_visibility.h"

namespace penumbra {

constexpr std::size_t kVerticesPerTask = 64;  // 5 ms of rays at the defaults: 8 threads stay busy on small meshes

// Returns the posed vertices. Their coefficients have room but no values yet. Throws InvalidInput when a vertex is
// not finite.
VisibilityFrame poseVertices(const BakePlan& plan, std::size_t frame);

// A posed frame with the scale of its scene and the acceleration structure that rays go through.
struct FrameScene {
    VisibilityFrame frame;
    SceneScale scale;
    OcclusionScene scene;
    std::vector<BoundingBox> part_boxes;  // with plan.local
    std::vector<Vec3> start_ways;         // with plan.places
    std::vector<Vec3> dense;              // with plan.chosen: the positions of all vertices of the source
};
// Where the moments of all vertices of a frame go.
MomentOutput outputOf(VisibilityFrame& frame);
FrameScene frameScene(const BakePlan& plan, std::size_t frame);

// The directions of a bake, with the basis of its order and with that of its local moments.
struct BakeDirections {
    RayDirections whole;
    std::optional<RayDirections> local;  // unset: there are no local moments, or they have the same order
    std::optional<RayReach> reach;       // set with --distance
};
// `diagonal` is that of BakePlan::rest_diagonal, the unit of scenes.
BakeDirections makeBakeDirections(const BakeOptions& options, double diagonal = 1);

// The tracer of a frame. It refers to all three arguments.
MomentTracer tracerOf(const BakePlan& plan, const FrameScene& posed, const BakeDirections& directions);

}  // namespace penumbra
