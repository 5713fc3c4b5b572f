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

// Cyclic Jacobi rotations until what is off the diagonal is below 1e-15 of the matrix (Golub, Van Loan, section 8.5).
// For matrices of some hundred rows at most; only the lower triangle of `matrix` [n, n] is read.
// Eigen's solver would do the same, but it gives some vectors the other sign, which changes most bytes of an asset.
SymmetricEigen symmetricEigen(std::span<const double> matrix, std::size_t n);

}  // namespace penumbra
