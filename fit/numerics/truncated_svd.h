#pragma once
#include "fit/numerics/matrix.h"

namespace penumbra {

struct TruncatedSvd {
    std::vector<double> sigma;  // descending
    Matrix u, v;                // [k, rows], [k, columns]: a ~= sum of sigma_b u_b v_b^T, a row a vector
};

// The `count` largest singular values of `a` (fewer where it has fewer rows or columns) and their vectors: residuals
// |a^T u - sigma v| below 1e-11 of the largest value. Deterministic, also where singular values are equal. Small
// matrices directly, others in a block Krylov space of a^T a (Golub, Luk and Overton 1981) from a fixed start.
TruncatedSvd truncatedSvd(const Matrix& a, std::size_t count);

}  // namespace penumbra
