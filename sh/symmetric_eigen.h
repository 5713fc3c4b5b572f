#pragma once
// Eigenvalues and eigenvectors of small symmetric matrices, by Jacobi's method: turn by turn, the rotation in the plane
// of two axes that makes their off-diagonal entry zero. For tables that are made once.
#include <span>

namespace penumbra {

// Turns the symmetric matrix `a` [n, n] (row-major) into a diagonal one, which holds the eigenvalues in no particular
// order. Column j of `vectors` [n, n] becomes the unit eigenvector of a[j, j].
void diagonalise(int n, std::span<double> a, std::span<double> vectors);

}  // namespace penumbra
