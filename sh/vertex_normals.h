#pragma once
// Normals of vertices that are given and not skinned: one rule for every stage, so that all have the same bits.
#include <cstdint>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

// Sums of the triangles' normals times their areas, in double precision and in the order of the triangles; a vertex
// without area gets a unit normal that points away from the centroid (or +y). Every result is unit. `triangles`: [3T]
// indices < V; `positions`, `scratch` and `normals`: [V]. Allocates nothing.
void vertexNormals(std::span<const std::uint32_t> triangles, std::span<const Vec3> positions, std::span<Vec3d> scratch,
                   std::span<Vec3> normals);

}  // namespace penumbra
