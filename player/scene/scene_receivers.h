#pragma once
// What the vertices of a scene see past its casters.
#include "player/frame/frame_values.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Computes the vertices of a member in the scene, with numbers past its own parts and all other casters. Where nobody
// casts on it, these are the very numbers that it has alone.
FrameVertices memberVertices(const PosedScene& scene, std::size_t member, int threads);

// The ground as a mesh of squares, and what it sees past all casters.
struct GroundVertices {
    std::vector<Vec3> positions, normals, tangents;  // [resolution^2]
    std::vector<float> mirrored;                     // [resolution^2, kFarNumbers] in the local frames
    std::vector<std::uint32_t> triangles;
};
GroundVertices groundVertices(const PosedScene& scene, int threads);
// E of each vertex, and what a Lambertian ground of the scene's albedo sends back from the scene's light.
std::vector<float> groundAmbient(const GroundVertices& ground);
std::vector<Vec3> groundRadiance(const PosedScene& scene, const GroundVertices& ground);

}  // namespace penumbra
