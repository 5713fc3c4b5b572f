#pragma once
// Computes the visibility past others over the whole sphere of directions, for the modes that compare
// (player/papers/cast_way.h).
#include <vector>

#include "runtime/cast/cast_shadow.h"

namespace penumbra {

// Writes V_c of the chosen casters for many receivers, in the frame of the scene: out[r * order^2 + i]. `order` is 4 or
// kCastOrder. Where all of them cast by spheres, V_c has the exponential of `cast`. A field is only known above a
// horizon, so with fields two halves are put together: one above the receiver and one below.
void castOverSphere(const CastShadow& cast, CasterChoice choice, int order, const CastReceivers& receivers, int threads,
                    std::vector<float>& out);

}  // namespace penumbra
