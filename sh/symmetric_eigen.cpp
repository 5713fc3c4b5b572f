#include "sh/symmetric_eigen.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace penumbra {

namespace {

// Makes a[p, q] zero. tan is the smaller root of t^2 + 2 t (a_qq - a_pp) / (2 a_pq) - 1 = 0 (Golub and Van Loan, 8.5).
void rotatePlane(std::size_t n, std::span<double> a, std::span<double> vectors, std::size_t p, std::size_t q) {
    const double off = a[p * n + q];
    if (off == 0) return;
    const double ratio = (a[q * n + q] - a[p * n + p]) / (2 * off);
    const double tangent = (ratio < 0 ? -1 : 1) / (std::abs(ratio) + std::hypot(1.0, ratio));
    const double cosine = 1 / std::hypot(1.0, tangent), sine = tangent * cosine;
    for (std::size_t i = 0; i < n; ++i) {  // columns p and q
        for (const std::span<double> matrix : {a, vectors}) {
            const double ip = matrix[i * n + p], iq = matrix[i * n + q];
            matrix[i * n + p] = cosine * ip - sine * iq;
            matrix[i * n + q] = sine * ip + cosine * iq;
        }
    }
    for (std::size_t i = 0; i < n; ++i) {  // rows p and q
        const double upper = a[p * n + i], lower = a[q * n + i];
        a[p * n + i] = cosine * upper - sine * lower;
        a[q * n + i] = sine * upper + cosine * lower;
    }
}

}  // namespace

void diagonalise(int count, std::span<double> a, std::span<double> vectors) {
    const std::size_t n = std::size_t(count);
    assert(a.size() == n * n && vectors.size() == n * n);
    std::fill(vectors.begin(), vectors.end(), 0.0);
    for (std::size_t i = 0; i < n; ++i) vectors[i * n + i] = 1;
    // The off-diagonal entries shrink quadratically: six sweeps suffice for n <= 8, the rest is for safety.
    for (int sweep = 0; sweep < 16; ++sweep) {
        double off = 0, all = 0;
        for (std::size_t i = 0; i < n * n; ++i) {
            all += a[i] * a[i];
            if (i / n != i % n) off += a[i] * a[i];
        }
        if (off <= 1e-34 * all) return;
        for (std::size_t p = 0; p + 1 < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) rotatePlane(n, a, vectors, p, q);
    }
}

}  // namespace penumbra
