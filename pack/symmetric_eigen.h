#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace penumbra {

// matrix = sum_k values[k] vectors_k vectors_k^T, values descending; the vectors are the orthonormal rows of `vectors`.
struct SymmetricEigen {
    std::vector<double> values;   // [n]
    std::vector<double> vectors;  // [n, n]
};

// Only the lower triangle of `matrix` [n, n] is read.
SymmetricEigen symmetricEigen(std::span<const double> matrix, std::size_t n);

}  // namespace penumbra
