#pragma once
// A convention turns a vertex' visibility into numbers in its local frame (z = normal). All conventions follow exactly
// from the hemisphere moments b_i = integral over s.N >= 0 of V y_i (Nowrouzezahrai 2009 eq. 1 and docs/formulas.md
// section 2).
//
// - A: V = 1 below the horizon; the numbers are b + Delta.
// - B: V = 0 below the horizon; the numbers are b.
// - D: mirrored, V(x,y,-z) = V(x,y,z); the numbers are 2 b for even l+m only.
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
    int size() const;                  // numbers of a vertex: order^2, or order (order+1) / 2 for D
    std::vector<int> indices() const;  // SH index of each number, ascending
    std::string name() const;          // such as "A4" or "D5"
};

// Reads "A4", "B5" or "D5": a letter and an order 1..kMaxOrder. Throws std::invalid_argument with a sentence.
Convention parseConvention(std::string_view name);

// Computes the numbers of `convention` from local-frame moments of an order >= convention.order. out.size() ==
// convention.size().
void fromMoments(const Convention& convention, std::span<const float> local_moments, std::span<float> out);

// Returns the SH function that the numbers stand for, as order^2 coefficients in the local frame. D has zeros at odd
// l+m.
void fullCoefficients(const Convention& convention, std::span<const float> coefficients, std::span<float> out);

// Writes the SH coefficients of "1 below the horizon" in the local frame, the Delta of convention A. out.size() ==
// coefficientCount(order).
void belowHorizonCoefficients(int order, std::span<double> out);

// Returns the integral over the sphere of the squared function itself, over all bands, for a visibility that is 0 or 1
// everywhere. Then V^2 = V, whose integral over the hemisphere is sqrt(4 pi) b_0. A adds the 2 pi below the horizon,
// and D doubles the integral. The squares of the numbers are the part that lies in the bands of the convention; the
// rest is the SH truncation.
double binaryEnergy(const Convention& convention, double moment0);

// Computes weights w such that E = (1/pi) integral over the hemisphere of V cos is sum_i w_i coefficients_i. E = 1
// means unshadowed. w.size() == convention.size().
void ambientWeights(const Convention& convention, std::span<float> w);

// Moves a vertex' coefficients the shortest way to where E = w . coefficients lies in [0, 1]. The truth lies there, so
// no error grows by it. `norm2` is w . w.
inline void clampAmbient(std::span<const float> w, float norm2, std::span<float> coefficients) {
    float e = 0;
    for (std::size_t i = 0; i < w.size(); ++i) e += w[i] * coefficients[i];
    const float excess = e < 0 ? e : e > 1 ? e - 1 : 0;
    if (excess == 0) return;
    for (std::size_t i = 0; i < w.size(); ++i) coefficients[i] -= w[i] * (excess / norm2);
}

}  // namespace penumbra
