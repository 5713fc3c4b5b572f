#pragma once
// Makes the signed distances of a part continuous where the part is open.
#include <span>

#include "sh/far/part_field.h"

namespace penumbra {

// The mesh of a part has holes where it joins other parts, and in a hole the distance from the surface is large on both
// sides of the place where its sign changes. A lookup would go from deep inside to far outside within millimetres.
//
// `distances` are those of the box' points, < 0 inside. `depth` is > 0 for points inside and <= 0 outside, and tells by
// how much: where it is linear between two neighbours, it is 0 at the border. Shortens distances so that the border
// counts as surface. Distances that are right already stay as they are.
void closeHoles(const FieldBox& box, std::span<const float> depth, std::span<float> distances);

}  // namespace penumbra
