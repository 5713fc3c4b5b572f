#pragma once
// Solves small least squares problems of any rank.
// Eigen's SVD does the same, but the search for directions amplifies last bits: some fits would find other lobes.
#include <array>

namespace penumbra {

constexpr int kMaxMinNorm = 15;  // largest number of rows and of columns

// A matrix stored column after column: at[j][i] is row i of column j.
struct SmallMatrix {
    int rows = 0, columns = 0;
    std::array<std::array<double, kMaxMinNorm>, kMaxMinNorm> at{};
};

// Returns, for every column of b, the shortest x that minimises |a x - b|^2 + ridge |x|^2. With the singular value
// decomposition a = U S V^T it is x = V S / (S^2 + ridge) U^T b. Singular values below 1e-9 of the largest count as
// zero. The decomposition is one-sided Jacobi (Hestenes 1958). `a` and `b` have the same number of rows.
SmallMatrix solveMinNorm(const SmallMatrix& a, const SmallMatrix& b, double ridge);

}  // namespace penumbra
