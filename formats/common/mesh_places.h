#pragma once
// Finds the shading points that stand at one place in every pose: one hard edge has several, with different normals.
#include <cstdint>
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Returns for each vertex [V] the first one of its place: that has the same rest position, skin row and moves of morph
// targets, bit by bit, so that lips which touch at rest are two places. A mesh without hard edges gives 0, 1, 2, ...
// A skin without rows compares rest positions and targets alone.
std::vector<std::uint32_t> firstOfPlaces(std::span<const Vec3> rest_positions, const Skin& skin,
                                         const MorphTargets& morphs = {});

// Returns firstOfPlaces() of the fronts of a mesh, where the two sides of a sheet are two places: points that only
// second twins use (twin_triangles.h) are of the other side, whatever the angles of hard edges are.
std::vector<std::uint32_t> firstOfSides(const Mesh& mesh, const Skin& skin);

// Returns the triangles with each corner moved to the first vertex of its place, so that surfaces hang together across
// hard edges.
std::vector<Triangle> trianglesOfPlaces(std::span<const Triangle> triangles, std::span<const std::uint32_t> first);

}  // namespace penumbra
