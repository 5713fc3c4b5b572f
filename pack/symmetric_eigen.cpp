#include "pack/symmetric_eigen.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace penumbra {

namespace {

// Of matrices with few rows Jacobi's method costs little, and assets keep their bytes: Eigen gives some vectors the
// other sign. Models of a thousand poses have some hundred rows.
constexpr std::size_t kFewRows = 128;

// Turns rows and columns p, q of the symmetric `a` so that a_pq = 0, and rows p, q of `vectors` with them.
void rotate(std::vector<double>& a, std::vector<double>& vectors, std::size_t n, std::size_t p, std::size_t q) {
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
    for (std::size_t i = 0; i < n; ++i) {
        const double x = a[p * n + i], y = a[q * n + i];
        a[p * n + i] = c * x - s * y;
        a[q * n + i] = s * x + c * y;
        const double u = vectors[p * n + i], v = vectors[q * n + i];
        vectors[p * n + i] = c * u - s * v;
        vectors[q * n + i] = s * u + c * v;
    }
}

// Cyclic Jacobi rotations until what is off the diagonal is below 1e-15 of the matrix (Golub, Van Loan, section 8.5).
SymmetricEigen byJacobi(std::span<const double> matrix, std::size_t n) {
    std::vector<double> a(matrix.begin(), matrix.end()), vectors(n * n, 0.0);
    double squares = 0;
    for (std::size_t i = 0; i < n; ++i) {
        vectors[i * n + i] = 1;
        for (std::size_t j = 0; j < i; ++j) a[j * n + i] = a[i * n + j];
        for (std::size_t j = 0; j <= i; ++j) squares += (j < i ? 2 : 1) * a[i * n + j] * a[i * n + j];
    }
    for (int sweep = 0; sweep < 60; ++sweep) {  // 6 to 10 sweeps are usual
        double off = 0;
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) off += 2 * a[p * n + q] * a[p * n + q];
        if (off <= 1e-30 * squares) break;
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q) rotate(a, vectors, n, p, q);
    }
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t i, std::size_t j) { return a[i * n + i] > a[j * n + j]; });
    SymmetricEigen result{{}, {}};
    for (std::size_t k : order) {
        result.values.push_back(a[k * n + k]);
        const auto row = vectors.begin() + std::ptrdiff_t(k * n);
        result.vectors.insert(result.vectors.end(), row, row + std::ptrdiff_t(n));
    }
    return result;
}

SymmetricEigen byTridiagonal(std::span<const double> matrix, std::size_t n) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto size = Eigen::Index(n);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::Map<const Rows>(matrix.data(), size, size));
    SymmetricEigen result{std::vector<double>(n), std::vector<double>(n * n)};
    for (Eigen::Index k = 0; k < size; ++k) {
        const Eigen::Index from = size - 1 - k;  // Eigen's values ascend
        result.values[std::size_t(k)] = solver.eigenvalues()[from];
        Eigen::Map<Eigen::VectorXd>(result.vectors.data() + k * size, size) = solver.eigenvectors().col(from);
    }
    return result;
}

}  // namespace

SymmetricEigen symmetricEigen(std::span<const double> matrix, std::size_t n) {
    assert(matrix.size() == n * n);
    return n <= kFewRows ? byJacobi(matrix, n) : byTridiagonal(matrix, n);
}

}  // namespace penumbra
