#pragma once
// Least squares of small matrices of any rank.
#include <array>

namespace penumbra {

constexpr int kMaxMinNorm = 15;  // rows and columns

// Column after column: columns[j][i] is row i of column j.
struct SmallMatrix {
    int rows = 0, columns = 0;
    std::array<std::array<double, kMaxMinNorm>, kMaxMinNorm> at{};
};

// The shortest x of those that minimise |a x - b|^2 + ridge |x|^2, for every column of b: x = V S / (S^2 + ridge) U^T b
// of the singular value decomposition of a, singular values below 1e-9 of the largest taken for zero. One-sided Jacobi
// (Hestenes 1958).
SmallMatrix solveMinNorm(const SmallMatrix& a, const SmallMatrix& b, double ridge);

}  // namespace penumbra
