#pragma once
// Counts the multiply-adds of L = l . t for a vertex and a view. The light is already in the vertex' frame, and one
// material channel serves three colours. Numbers that are not zero (1e-7 of the largest) count once. The count follows
// the run-time kernel: it sums the entries of the matrix that takes v to t, where entries that are equal by symmetry
// count once, and then applies the matrix.
#include <algorithm>
#include <cmath>
#include <map>

#include "formats/stage/brdf_file.h"
#include "sh/brdf/reflection_operator.h"
#include "sh/sh_product.h"
#include "tests/difference.h"

namespace penumbra {

struct WorkCount {
    std::size_t view = 0, sums = 0, entries = 0;  // f = A y(o); sums that make the matrix; entries of the matrix
    std::size_t total(int light_order) const {
        return view + sums + entries + 3 * std::size_t(coefficientCount(light_order));
    }
};

// Returns how many of [count, 3] are not zero in the first channel.
inline std::size_t nonZeros(const std::vector<double>& values) {
    const double largest = largestMagnitude(values);
    std::size_t count = 0;
    for (std::size_t i = 0; i < values.size(); i += 3) count += std::abs(values[i]) > 1e-7 * largest;
    return count;
}

// terms[i, j] is how many terms are summed for that entry. (i, j) and (j, i) are equal where both are there.
inline WorkCount countMatrix(const std::map<std::pair<int, int>, std::size_t>& terms) {
    WorkCount count;
    for (const auto& [at, n] : terms) {
        const bool mirrored = at.first > at.second && terms.count({at.second, at.first}) > 0;
        count.sums += mirrored ? 0 : n;
        count.entries += 1;
    }
    return count;
}

// Counts f = C y, the matrix of Gamma and f, and its product.
inline WorkCount multiplyAdds(const BrdfFile& brdf, int light_order, const Convention& convention) {
    const std::size_t columns = brdf.even_index.size(), rows = brdf.slices.size() / columns / 3;
    std::vector<bool> used(rows), number(std::size_t(coefficientCount(convention.order)));
    for (int index : convention.indices()) number[std::size_t(index)] = true;
    for (std::size_t i = 0; i < brdf.slices.size(); i += 3)
        if (std::abs(brdf.slices[i]) > 1e-7) used[i / 3 / columns] = true;
    std::map<std::pair<int, int>, std::size_t> terms;
    for (const TripleProductEntry& e : tripleProduct(light_order, convention.order, brdf.slice_order))
        if (number[e.j] && used[e.k]) ++terms[{e.i, e.j}];
    WorkCount count = countMatrix(terms);
    count.view = nonZeros(brdf.slices);
    return count;
}

// Counts s_b = w_b . y and the matrix sum of s_b M^b. `dense` counts every entry of M^b, as for a routine that knows
// nothing of its zeros.
inline WorkCount multiplyAdds(const BrdfOperators& operators, int light_order, const Convention& convention,
                              bool dense) {
    const std::size_t rows = std::size_t(coefficientCount(operators.order)), k = std::size_t(operators.count);
    const std::vector<int> index = convention.indices();
    std::map<std::pair<int, int>, std::size_t> terms;
    for (std::size_t b = 0; b < k; ++b) {
        std::vector<double> u(rows);
        for (std::size_t i = 0; i < rows; ++i) u[i] = operators.u[(b * rows + i) * 3];
        const std::vector<double> m = reflectionOperator(light_order, convention, u);
        for (std::size_t at = 0; at < m.size(); ++at)
            if (dense || std::abs(m[at]) > 1e-7) ++terms[{int(at / index.size()), index[at % index.size()]}];
    }
    WorkCount count = countMatrix(terms);
    count.view = dense ? operators.w.size() / 3 : nonZeros(operators.w);
    return count;
}

}  // namespace penumbra
