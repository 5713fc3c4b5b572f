#pragma once
// The visibility past the spheres of casters, for many receivers at once. It is what netLog() and expOfLog() with its
// default options give, computed for 8 receivers at a time.
#include <span>

#include "sh/cap_visibility.h"
#include "sh/cast/cast_kernel.h"

namespace penumbra {

// Writes the visibility past all `spheres` at each position, over the whole sphere of directions and in the frame of
// the spheres: out[r * order^2 + i]. `order` is from kLeastLogOrder to kMostLogOrder. Allocates nothing, but the first
// call of an order makes its tables.
void castVisibility(int order, std::span<const CasterSphere> spheres, std::span<const Vec3> positions,
                    std::span<float> out, const CastPath& path = fastestCastPath());

}  // namespace penumbra
