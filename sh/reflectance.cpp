#include "sh/reflectance.h"

#include <array>
#include <cassert>

namespace penumbra {

std::vector<int> evenIndices(int order) {
    std::vector<int> indices;
    for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; m += 2) indices.push_back(shIndex(l, m));
    return indices;
}

void evalEvenBasis(int order, Vec3 direction, std::span<float> out) {
    assert(int(out.size()) == order * (order + 1) / 2);
    std::array<float, coefficientCount(kMaxOrder)> basis;
    evalBasis(order, direction, std::span(basis).first(coefficientCount(order)));
    std::size_t e = 0;
    for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; m += 2) out[e++] = basis[shIndex(l, m)];
}

}  // namespace penumbra
