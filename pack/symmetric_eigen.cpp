#include "pack/symmetric_eigen.h"

#include <Eigen/Eigenvalues>
#include <cassert>

namespace penumbra {

SymmetricEigen symmetricEigen(std::span<const double> matrix, std::size_t n) {
    assert(matrix.size() == n * n);
    if (n == 0) return {};
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto size = Eigen::Index(n);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::Map<const Rows>(matrix.data(), size, size));
    SymmetricEigen result{std::vector<double>(n), std::vector<double>(n * n)};
    for (Eigen::Index k = 0; k < size; ++k) {
        const Eigen::Index from = size - 1 - k;  // Eigen's values ascend
        const Eigen::VectorXd vector = solver.eigenvectors().col(from);
        Eigen::Index largest = 0;
        vector.cwiseAbs().maxCoeff(&largest);
        result.values[std::size_t(k)] = solver.eigenvalues()[from];
        Eigen::Map<Eigen::VectorXd>(result.vectors.data() + k * size, size) = vector(largest) < 0 ? -vector : vector;
    }
    return result;
}

}  // namespace penumbra
