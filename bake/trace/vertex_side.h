#pragma once
// The triangles around a vertex divide the directions from it into a front and a back part. On a crumpled sheet the
// vertex normal, which is a mean, may lie in the wrong part. Rays that started there would see what the other side
// sees.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Holds for each vertex the other two corners of each of its triangles, in the order of the triangle. The entries of
// vertex v are corners[begin[v]] to corners[begin[v + 1] - 1].
struct VertexFans {
    std::vector<std::uint32_t> begin;                   // [V + 1]
    std::vector<std::array<std::uint32_t, 2>> corners;  // [3 T]
};
VertexFans makeFans(std::span<const Triangle> triangles, std::size_t vertices);

// Returns a unit direction from `vertex` into the part that the triangles' fronts face (side 1) or their backs (side
// -1). `normal` is the vertex normal of that side. It is the answer wherever it lies in the right part. Elsewhere the
// answer is the direction that is farthest from all triangles, out of the triangles' normals, the means of two
// neighbours' normals and, in a corner of three faces, the mean of all; it is `normal` again where none of them lies in
// the right part. The nearest triangle decides on which side a direction lies; at an edge the sum of both normals
// decides (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal").
Vec3 directionToSide(const VertexFans& fans, std::span<const Vec3> positions, std::uint32_t vertex, Vec3 normal,
                     int side);

}  // namespace penumbra
