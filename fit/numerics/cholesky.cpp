#include "fit/numerics/cholesky.h"

#include <cassert>
#include <cmath>

namespace penumbra {

void factorCholesky(std::vector<double>& a, std::size_t n) {
    assert(a.size() == n * n);
    // Column j: the diagonal first, then the entries below it.
    for (std::size_t j = 0; j < n; ++j) {
        double diagonal = a[j * n + j];
        for (std::size_t k = 0; k < j; ++k) diagonal -= a[j * n + k] * a[j * n + k];
        assert(diagonal > 0);
        a[j * n + j] = std::sqrt(diagonal);
        for (std::size_t i = j + 1; i < n; ++i) {
            double sum = a[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
            a[i * n + j] = sum / a[j * n + j];
        }
    }
}

void solveCholesky(const std::vector<double>& factored, std::span<double> x) {
    const std::size_t n = x.size();
    assert(factored.size() == n * n);
    // 1. Solve L y = x from the first row to the last.
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) x[i] -= factored[i * n + k] * x[k];
        x[i] /= factored[i * n + i];
    }
    // 2. Solve L^T x = y from the last row to the first.
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) x[i] -= factored[k * n + i] * x[k];
        x[i] /= factored[i * n + i];
    }
}

}  // namespace penumbra
