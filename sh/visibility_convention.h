#pragma once
// How a vertex' visibility is turned into numbers in its local frame (z = normal). Everything derives from the
// hemisphere moments b_i = integral over s.N >= 0 of V y_i, exactly (paper 000 eq. 1 and docs/formulas.md section 2):
//   A: V = 1 below the horizon, b + Delta.   B: V = 0 below, b.   D: mirrored, V(x,y,-z) = V(x,y,z): 2 b for l+m even
//   only.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sh/sh_basis.h"

namespace penumbra {

enum class BelowHorizon : char { kOpen = 'A', kBlocked = 'B', kMirrored = 'D' };

struct Convention {
    BelowHorizon below = BelowHorizon::kMirrored;
    int order = 5;

    bool operator==(const Convention&) const = default;
    int size() const;                  // numbers a vertex: order^2, or order (order+1) / 2 for D
    std::vector<int> indices() const;  // SH index of each number, ascending
    std::string name() const;          // "A4", "D5", ...
};

// "A4", "B5", "D5": letter and order 1..kMaxOrder. Throws std::invalid_argument with a sentence.
Convention parseConvention(std::string_view name);

// Numbers of `convention` from local-frame moments of an order >= convention.order. out.size() == convention.size().
void fromMoments(const Convention& convention, std::span<const float> local_moments, std::span<float> out);

// The SH function that the numbers stand for, as order^2 coefficients in the local frame (D: zeros at odd l+m).
void toCoefficients(const Convention& convention, std::span<const float> numbers, std::span<float> out);

// SH coefficients of "1 below the horizon", local frame: Delta of convention A. out.size() == coefficientCount(order).
void belowHorizonCoefficients(int order, std::span<double> out);

// Integral over the sphere of the squared function itself, all bands, where visibility is 0 or 1 everywhere: then
// V^2 = V, whose integral over the hemisphere is sqrt(4 pi) b_0. A adds the 2 pi below the horizon, D doubles. The
// numbers' squares are what of it lies in the bands of the convention; the rest is the SH truncation.
double binaryEnergy(const Convention& convention, double moment0);

// E = (1/pi) integral over the hemisphere of V cos: weights w with E = sum_i w_i numbers_i. 1 = unshadowed.
// w.size() == convention.size().
void ambientWeights(const Convention& convention, std::span<float> w);

// Moves a vertex' numbers the shortest way to where E = w . numbers lies in [0, 1]: the truth lies there, so an error
// never grows by it. `norm2` is w . w.
inline void clampAmbient(std::span<const float> w, float norm2, std::span<float> numbers) {
    float e = 0;
    for (std::size_t i = 0; i < w.size(); ++i) e += w[i] * numbers[i];
    const float excess = e < 0 ? e : e > 1 ? e - 1 : 0;
    if (excess == 0) return;
    for (std::size_t i = 0; i < w.size(); ++i) numbers[i] -= w[i] * (excess / norm2);
}

}  // namespace penumbra
