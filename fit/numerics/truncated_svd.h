#pragma once
#include "fit/numerics/matrix.h"

namespace penumbra {

struct TruncatedSvd {
    std::vector<double> sigma;  // descending
    Matrix u, v;                // [k, rows] and [k, columns], one vector a row: a ~= sum of sigma_b u_b v_b^T
};

// Returns the `count` largest singular values of `a` and their vectors, or fewer where `a` has fewer rows or columns.
// The residuals |a^T u - sigma v| are below 1e-11 of the largest value. The result is deterministic, even where
// singular values are equal. Small matrices are decomposed directly, others by a subspace iteration from a fixed start.
TruncatedSvd truncatedSvd(const Matrix& a, std::size_t count);

}  // namespace penumbra
