#pragma once
// The numbers of a vertex that stand for the light that reaches it from other surfaces: its indirect transfer, summed
// over all bounces, in each colour channel (docs/formulas.md, section 13).
//
// Surfaces near a vertex have few colours, so the three channels are nearly proportional to one another. We therefore
// turn colours to three orthonormal axes, which are the principal axes of the whole mesh. The first axis has all
// coefficients of order 3, and the other two only the mean over directions: 11 numbers in place of 27.
#include <array>
#include <cassert>
#include <cstddef>
#include <span>

#include "sh/vec3.h"

namespace penumbra {

constexpr int kIndirectOrder = 3;  // SH bands. Light that bounced is smooth: bands 0..2 have 99.9% of its energy
constexpr std::size_t kIndirectCoefficients = std::size_t(kIndirectOrder) * kIndirectOrder;
constexpr std::size_t kIndirectSize = kIndirectCoefficients + 2;
constexpr std::size_t kIndirectStride = 12;  // numbers of a vertex in arrays, the last one 0

// Row k is axis k, as a linear RGB colour.
using ColorAxes = Mat3;

// Computes the numbers from the transfer of three channels, [3, n2] with n2 >= kIndirectCoefficients.
inline void toIndirectCoefficients(const ColorAxes& axes, std::span<const float> transfer,
                                   std::span<float> coefficients) {
    const std::size_t n2 = transfer.size() / 3;
    assert(n2 >= kIndirectCoefficients && coefficients.size() >= kIndirectSize);
    const auto along = [&](int axis, std::size_t i) {
        return axes(axis, 0) * transfer[i] + axes(axis, 1) * transfer[n2 + i] + axes(axis, 2) * transfer[2 * n2 + i];
    };
    for (std::size_t i = 0; i < kIndirectCoefficients; ++i) coefficients[i] = along(0, i);
    coefficients[kIndirectCoefficients] = along(1, 0);
    coefficients[kIndirectCoefficients + 1] = along(2, 0);
}

// Returns coefficient i of the transfer as a colour.
inline Vec3 indirectCoefficient(const ColorAxes& axes, std::span<const float> coefficients, std::size_t i) {
    Vec3 color = coefficients[i] * Vec3{axes(0, 0), axes(0, 1), axes(0, 2)};
    if (i == 0)
        for (int k = 1; k < 3; ++k)
            color +=
                coefficients[kIndirectCoefficients + std::size_t(k) - 1] * Vec3{axes(k, 0), axes(k, 1), axes(k, 2)};
    return color;
}

}  // namespace penumbra
