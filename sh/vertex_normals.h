#pragma once
// Computes the normals of vertices that are given and not skinned. All stages use this one rule, so all have the same
// bits.
#include <cstdint>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

// Sums the triangles' normals times their areas, in double precision and in the order of the triangles. A vertex
// without area gets a unit normal that points away from the centroid, or +y at the centroid. Every result has length 1.
// `triangles` holds [3T] indices < V; `positions`, `scratch` and `normals` are [V]. It allocates nothing.
void vertexNormals(std::span<const std::uint32_t> triangles, std::span<const Vec3> positions, std::span<Vec3d> scratch,
                   std::span<Vec3> normals);

}  // namespace penumbra
