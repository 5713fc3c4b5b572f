#pragma once
// Computes the visibility past the casters on the ground of a scene.
#include <array>

#include "player/scene/cast_blocks.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// A mesh of squares that face up.
struct GroundVertices {
    std::uint32_t side = 0;                          // vertices
    std::vector<Vec3> positions, normals, tangents;  // [side^2]; all have one local frame
    std::vector<float> mirrored;                     // [side^2, kFarCoefficients] in it, past all casters
    std::vector<std::uint32_t> triangles;
    // Fewer triangles, which look the same: where the numbers are interpolated, 4 of a block. Empty: there are none.
    std::vector<std::uint32_t> drawn;
    std::span<const std::uint32_t> shown() const { return drawn.empty() ? triangles : drawn; }
    std::vector<CastBlock> blocks;  // results of the last cast
    std::size_t evaluated = 0;      // vertices; the others lie between evaluated ones
};
// Returns the vertices of a ground that nobody casts on yet, with room for their numbers.
GroundVertices groundMesh(const SceneGround& ground);
// Writes what the vertices of a ground see past casters, and the triangles that show it.
void castOnGround(const CastShadow& cast, int threads, GroundVertices& ground);
GroundVertices groundVertices(const SceneGround& ground, const CastShadow& cast, int threads);
GroundVertices groundVertices(const PosedScene& scene, int threads);
// All vertices have one frame, so that irradiance is one weighted sum of a vertex' numbers: w_i = integral over the
// hemisphere of L cos y_i. The light's SH are turned by `rotation`.
using GroundWeights = std::array<Vec3d, kFarCoefficients>;
GroundWeights groundWeights(const GroundVertices& ground, const LightView& light, const Mat3d& rotation);
// E of each vertex, and what a Lambertian ground sends back from a light whose SH are turned by `rotation`.
std::vector<float> groundAmbient(const GroundVertices& ground);
void groundAmbient(const GroundVertices& ground, std::vector<float>& e);
// A light, turned by `rotation`, on a ground of one albedo.
struct LitGround {
    const LightView& light;
    const Mat3d& rotation;
    Vec3 albedo;
};
std::vector<Vec3> groundRadiance(const GroundVertices& ground, const LightView& light, const Mat3d& rotation,
                                 Vec3 albedo, int threads);
void groundRadiance(const GroundVertices& ground, const LitGround& lit, int threads, std::vector<Vec3>& radiance);
// The same for the light and the ground of the scene.
std::vector<Vec3> groundRadiance(const PosedScene& scene, const GroundVertices& ground, int threads);

}  // namespace penumbra
