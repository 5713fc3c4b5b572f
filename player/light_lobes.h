#pragma once
// An SH light as zonal lobes around fixed directions, exactly: l_lm = sum over d of w_dl y_lm(s_d). In a rotated frame
// only the directions rotate, so a shader needs no SH rotation: with local = Q model,
//   l . (Q^T t) = sum over d and l of w_dl sum over m of y_lm(Q s_d) t_lm.
#include <vector>

#include "formats/asset_file.h"

namespace penumbra {

struct LightLobes {
    std::vector<Vec3> directions;  // [D], D = 3 order - 1
    std::vector<Vec3> weights;     // [D, order], RGB
};

// 2 order - 1 directions would do (the size of the last band); the half as many more bring the worst condition number
// of the per-band systems from 47 to 7 for orders up to 8.
LightLobes makeLightLobes(const LightView& light);

}  // namespace penumbra
