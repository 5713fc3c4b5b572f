#pragma once
// Solves small dense symmetric positive definite systems in double precision.
// Eigen's LLT does the same, but it adds in another order: last bits (6e-17) of a material's slices would change.
#include <span>
#include <vector>

namespace penumbra {

// Overwrites the lower triangle of the n x n row-major matrix `a` with L, where a = L L^T. Asserts that `a` is positive
// definite.
void factorCholesky(std::vector<double>& a, std::size_t n);
// Replaces x by a^-1 x for a factored `a`; x.size() == n.
void solveCholesky(const std::vector<double>& factored, std::span<double> x);

}  // namespace penumbra
