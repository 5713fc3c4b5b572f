#pragma once
// Writes an SH light exactly as zonal lobes around fixed directions: l_lm = sum over d of w_dl y_lm(s_d). In a
// rotated frame only the directions rotate, so a shader needs no SH rotation ("The light in a vertex' frame" in
// section 3 of docs/formulas.md). With local = Q model,
//   l . (Q^T t) = sum over d and l of w_dl sum over m of y_lm(Q s_d) t_lm.
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

struct LightLobes {
    std::vector<Vec3> directions;  // [D], D = 2 order - 1: as many as the last band has functions
    std::vector<Vec3> weights;     // [D, order], RGB
};

// Makes lobes for a light. Their directions are a spherical Fibonacci set over half the sphere. They span every band:
// the worst condition number of the systems of the bands is 47, for orders up to 8.
LightLobes makeLightLobes(const LightView& light);

}  // namespace penumbra
