#include "pack/symmetric_eigen.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <numeric>

#include "sh/symmetric_eigen.h"

namespace penumbra {

namespace {

// Of matrices with few rows Jacobi's method costs little, and assets keep their bytes: Eigen gives some vectors the
// other sign. Models of a thousand poses have some hundred rows.
constexpr std::size_t kFewRows = 128;

SymmetricEigen byJacobi(std::span<const double> matrix, std::size_t n) {
    std::vector<double> a(matrix.begin(), matrix.end()), vectors(n * n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < i; ++j) a[j * n + i] = a[i * n + j];
    diagonalise(n, a, vectors);
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
