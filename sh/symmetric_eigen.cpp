#include "sh/symmetric_eigen.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

// Turns rows and columns p, q of the symmetric `a` so that a_pq = 0, and rows p, q of `vectors` with them.
void rotatePlane(std::size_t n, std::span<double> a, std::span<double> vectors, std::size_t p, std::size_t q) {
    const double off = a[p * n + q];
    if (off == 0) return;
    const double theta = (a[q * n + q] - a[p * n + p]) / (2 * off);
    const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::hypot(theta, 1.0));
    const double c = 1 / std::hypot(t, 1.0), s = t * c;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = a[i * n + p], y = a[i * n + q];
        a[i * n + p] = c * x - s * y;
        a[i * n + q] = s * x + c * y;
    }
    for (std::size_t i = 0; i < n; ++i)
        for (const std::span<double> rows : {a, vectors}) {
            const double x = rows[p * n + i], y = rows[q * n + i];
            rows[p * n + i] = c * x - s * y;
            rows[q * n + i] = s * x + c * y;
        }
}

}  // namespace

void diagonalise(std::size_t n, std::span<double> a, std::span<double> vectors) {
    assert(a.size() == n * n && vectors.size() == n * n);
    double squares = 0;
    std::ranges::fill(vectors, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        vectors[i * n + i] = 1;
        for (std::size_t j = 0; j <= i; ++j) squares += (j < i ? 2 : 1) * a[i * n + j] * a[i * n + j];
    }
    for (int sweep = 0; sweep < 60; ++sweep) {  // 6 to 10 sweeps are usual
        double off = 0;
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) off += 2 * a[p * n + q] * a[p * n + q];
        if (off <= 1e-30 * squares) break;
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) rotatePlane(n, a, vectors, p, q);
    }
}

}  // namespace penumbra
