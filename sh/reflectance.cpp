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

void evalSlice(std::span<const float> slices, int slice_order, int view_order, Vec3 omega_o, std::span<float> f) {
    const int even_count = view_order * (view_order + 1) / 2;
    const int count = coefficientCount(slice_order);
    assert(int(f.size()) == count && int(slices.size()) == count * even_count);
    std::array<float, kMaxOrder*(kMaxOrder + 1) / 2> even;
    evalEvenBasis(view_order, omega_o, std::span(even).first(even_count));
    for (int i = 0; i < count; ++i) {
        float sum = 0;
        for (int e = 0; e < even_count; ++e) sum += slices[i * even_count + e] * even[e];
        f[i] = sum;
    }
}

}  // namespace penumbra
