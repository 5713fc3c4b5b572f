#pragma once
// Shadows that others cast, as a change of the light. V_c is the visibility past other characters at a receiver, over
// the whole sphere. The light L' = L V_c then shades the receiver, whose own visibility is as before. This is a
// reference: scenes mirror V_c at the receiver's horizon and multiply it to the receiver's own visibility, which has
// less error (docs/formulas.md, section 10).
#include <span>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

// The light of all receivers, as the matrix that V_c is multiplied by: L'_ic = sum_k (sum_j Gamma_ijk L_jc) V_k.
struct CastFold {
    int light_order = 0, cast_order = 0;
    std::vector<float> matrix;  // [cast_order^2, light_order^2, 3]
};

// `light` is [light_order^2, 3], the colours last, in the frame that V_c is in. Both orders <= kMaxOrder.
CastFold makeCastFold(int light_order, std::span<const float> light, int cast_order);

// Writes L' [light_order^2, 3], the product with `cast` [cast_order^2]. Allocates nothing.
void foldCast(const CastFold& fold, std::span<const float> cast, std::span<float> out);

}  // namespace penumbra
