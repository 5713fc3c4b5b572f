#pragma once
// Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi's method.
#include <cstddef>
#include <span>

namespace penumbra {

// Turns the symmetric matrix `a` [n, n] into a diagonal one, which holds the eigenvalues in no particular order, by
// cyclic rotations until what is off the diagonal is below 1e-15 of the matrix (Golub and Van Loan, section 8.5). Row j
// of `vectors` [n, n] becomes the unit eigenvector of a[j, j].
void diagonalise(std::size_t n, std::span<double> a, std::span<double> vectors);

}  // namespace penumbra
