#pragma once
// Triangles at one place that face opposite ways: the two layers of a cape, or the two sides of a leaf.
#include "formats/common/mesh.h"

namespace penumbra {

// Returns for each triangle [T] of a skinned mesh the one of the other side: its corners have the same rest positions
// and the same skin rows, in the other order. A triangle without one has its own number. Of several that fit, the
// first ones belong together. Empty where no triangle has a twin.
std::vector<std::uint32_t> twinTriangles(const Mesh& mesh, const Skin& skin);

// Does the same by rest positions alone.
std::vector<std::uint32_t> twinsByPlace(std::span<const Triangle> triangles, std::span<const Vec3> rest_positions);

// Returns for each vertex [V] the one of the other side, which its triangles' twins use, or the vertex itself.
std::vector<std::uint32_t> twinVertices(const Mesh& mesh, std::span<const std::uint32_t> twins);

// Returns the corners of `triangle`'s twin in the order of its own corners: each is at the same place.
Triangle twinCorners(const Mesh& mesh, std::size_t triangle, std::size_t twin);

// Returns for each vertex [V] that of the traced side: of the first twin, for one that only second twins use; else the
// vertex itself.
std::vector<std::uint32_t> tracedVertices(const Mesh& mesh, std::span<const std::uint32_t> twins);

}  // namespace penumbra
