#pragma once
// Surfaces of what stands in a photograph besides the ground, and how much characters brighten or darken them.
#include <vector>

#include "player/composite/ground_ratio.h"
#include "player/frame/frame_values.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Triangles with normals of their own, small enough that what vertices know can be interpolated.
struct RealSurface {
    std::vector<Vec3> positions, normals, tangents;  // in the scene
    std::vector<std::uint32_t> triangles;
    std::size_t caster = kNobody,
                real_caster = kNobody;  // its index among all casters, and among those in the photograph
    std::vector<Vec3> ratio;            // one for each vertex, see GroundRatio
};

// Cuts triangles in halves until no edge is longer than `edge` metres, or there are 200,000. Every triangle has its own
// vertices, with its own normal.
RealSurface surfaceOf(const RealMesh& mesh, double edge);

// Computes the ratios as GroundRatio does, but the light without suns at a vertex is that of its normal times the share
// of a white sky that it sees: its light from one side cannot be hidden alone.
void shadeSurface(const PosedScene& scene, const GroundLight& light, std::span<const float> light_sh, int threads,
                  RealSurface& surface);

}  // namespace penumbra
