#pragma once
// Transfer from the slices and the D5 vectors of golden files, in double precision (docs/formulas.md, section 3).
#include <vector>

#include "sh/reflectance.h"
#include "sh/sh_product.h"
#include "tests/sh/golden.h"

namespace penumbra {

// The rows of Q are tangent, normal x tangent and normal.
inline Mat3d localFrame(Vec3d normal, Vec3d tangent) { return fromRows(tangent, cross(normal, tangent), normal); }

// f = C y_even(o) for the direction o towards the eye in the local frame.
inline std::vector<double> sliceOf(const nlohmann::json& slices, Vec3d to_eye) {
    std::vector<double> y(25), f;
    evalBasis(5, to_eye, y);
    const std::vector<int> even = evenIndices(5);
    for (const auto& row : slices) {
        double sum = 0;
        for (std::size_t e = 0; e < even.size(); ++e) sum += row.at(e).get<double>() * y[std::size_t(even[e])];
        f.push_back(sum);
    }
    return f;
}

// t = d x f over the sphere, order 4.
inline std::vector<double> transferOf(const nlohmann::json& d5, const std::vector<double>& f) {
    std::vector<double> d(25), t(16);
    const std::vector<int> even = evenIndices(5);
    for (std::size_t e = 0; e < even.size(); ++e) d[std::size_t(even[e])] = d5.at(e);
    multiply(4, d, 5, f, 5, t);
    return t;
}

}  // namespace penumbra
