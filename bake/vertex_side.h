#pragma once
// The triangles around a vertex divide the directions from it into a front and a back part. On a crumpled sheet the
// vertex normal, a mean, may lie in the wrong one: rays that started there would see what the other side sees.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// For each vertex the other two corners of its triangles, in their order.
struct VertexFans {
    std::vector<std::uint32_t> begin;                   // [V + 1]
    std::vector<std::array<std::uint32_t, 2>> corners;  // [3 T]
};
VertexFans makeFans(std::span<const Triangle> triangles, std::size_t vertices);

// A unit direction from `vertex` into the part that the fronts face (side 1) or the backs (side -1): `normal`, that
// side's, where it is one; else the one of the triangles' normals and the means of two neighbours' that is farthest
// from all triangles; `normal` again where none will do. The part of a direction is decided at the nearest triangle, at
// an edge by the sum of both normals (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted
// pseudonormal").
Vec3 directionToSide(const VertexFans& fans, std::span<const Vec3> positions, std::uint32_t vertex, Vec3 normal,
                     int side);

}  // namespace penumbra
