#pragma once
// Where rays start on triangles that are much larger than the character or far from it.
#include <span>
#include <vector>

#include "formats/common/mesh.h"

namespace penumbra {

// Returns a bias for each vertex, in diagonals of `character`: `bias`, or more where floats do not resolve that, which
// is by the distance from the character and by the edges of the triangles around the vertex. Empty where `bias` is
// enough everywhere.
std::vector<float> farBiases(std::span<const Triangle> triangles, std::span<const Vec3> positions,
                             const BoundingBox& character, float bias);

}  // namespace penumbra
