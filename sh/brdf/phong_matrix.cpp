#include "sh/brdf/phong_matrix.h"

#include <cassert>

#include "sh/brdf/mirror_lobe.h"

namespace penumbra {

std::vector<double> phongMatrix(double alpha, int order) {
    assert(alpha >= 0);
    std::vector<double> moments;  // the integrals of z^alpha z^k over (0, 1)
    for (int k = 0; k < 2 * order - 1; ++k) moments.push_back(1 / (alpha + 1 + k));
    return mirrorLobeMatrix(order, order, moments);
}

}  // namespace penumbra
