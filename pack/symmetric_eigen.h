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

// Only the lower triangle of `matrix` [n, n] is read. The largest number of each vector is positive, so that assets do
// not depend on the signs that a solver happens to give.
SymmetricEigen symmetricEigen(std::span<const double> matrix, std::size_t n);

}  // namespace penumbra
