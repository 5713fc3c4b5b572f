#pragma once
// The plain product of slices and a view, which tests of shading and of compact forms compare with.
#include <array>
#include <cassert>
#include <span>

#include "sh/reflectance.h"

namespace penumbra {

// Evaluates f_i = sum_e C[i, e] y_even_e(omega_o) in the local frame. `slices` is [J^2, E], row-major, of one colour
// channel.
inline void evalSlice(std::span<const float> slices, int slice_order, int view_order, Vec3 omega_o,
                      std::span<float> f) {
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
