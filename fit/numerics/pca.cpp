#include "fit/numerics/pca.h"

#include <algorithm>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

constexpr double kRankTolerance = 1e-12;  // relative to the total energy; float rows do not resolve smaller energies
constexpr Eigen::Index kBlock = 512;      // columns (or rows) that are converted to double at a time

// Returns the lower triangle of rows rows^T if `from_rows`, else of rows^T rows.
template <class T>
Eigen::MatrixXd smallerGram(const BasicMatrix<T>& rows, bool from_rows) {
    const auto m = asEigen(rows);
    const Eigen::Index size = from_rows ? m.rows() : m.cols(), length = from_rows ? m.cols() : m.rows();
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size), block;
    for (Eigen::Index begin = 0; begin < length; begin += kBlock) {
        const Eigen::Index n = std::min(kBlock, length - begin);
        if (from_rows)
            block = m.middleCols(begin, n).template cast<double>();
        else
            block = m.middleRows(begin, n).template cast<double>().transpose();
        gram.selfadjointView<Eigen::Lower>().rankUpdate(block);
    }
    return gram;
}

// Makes the entry of largest magnitude of each column positive.
void fixSign(Eigen::MatrixXd& vectors) {
    for (Eigen::Index k = 0; k < vectors.cols(); ++k) vectors.col(k) *= signOf(vectors.col(k));
}

template <class T>
Pca componentsOf(const BasicMatrix<T>& rows) {
    Pca pca;
    pca.from_rows = rows.rows <= rows.columns;
    // 1. Solve the smaller eigenproblem.
    pca.scores = Matrix(rows.rows, 0);
    if (rows.values.empty()) return pca;
    const EigenPairs pairs = symmetricEigenPairs(smallerGram(rows, pca.from_rows));
    const Eigen::VectorXd values = pairs.values.reverse().cwiseMax(0.0);
    Eigen::MatrixXd vectors = pairs.vectors.rowwise().reverse();
    fixSign(vectors);
    pca.total = values.sum();
    // 2. Leave out components that are only rounding.
    while (pca.energies.size() < std::size_t(values.size()) &&
           values[Eigen::Index(pca.energies.size())] > kRankTolerance * pca.total)
        pca.energies.push_back(values[Eigen::Index(pca.energies.size())]);

    const auto rank = Eigen::Index(pca.energies.size());
    const Eigen::VectorXd sigma = values.head(rank).cwiseSqrt();
    // 3. Compute the scores. From the eigenvectors of rows rows^T they are U sigma, and the basis is (U / sigma)^T
    //    rows, which basisOf() multiplies out when it is asked to. The eigenvectors of rows^T rows are the basis
    //    itself.
    pca.scores = Matrix(rows.rows, pca.energies.size());
    if (pca.from_rows) {
        asEigen(pca.scores) = vectors.leftCols(rank) * sigma.asDiagonal();
        pca.to_basis = Matrix(rows.rows, pca.energies.size());
        asEigen(pca.to_basis) = vectors.leftCols(rank) * sigma.cwiseInverse().asDiagonal();
    } else {
        pca.to_basis = Matrix(pca.energies.size(), rows.columns);
        asEigen(pca.to_basis) = vectors.leftCols(rank).transpose();
        asEigen(pca.scores) = asEigen(rows).template cast<double>() * vectors.leftCols(rank);
    }
    return pca;
}

template <class T>
BasicMatrix<T> basisRows(const Pca& pca, const BasicMatrix<T>& rows, std::size_t count) {
    BasicMatrix<T> basis(count, rows.columns);
    const auto known = Eigen::Index(std::min(count, pca.energies.size()));
    const auto m = asEigen(rows);
    auto out = asEigen(basis);
    // 1. The basis may be known already.
    if (!pca.from_rows) {
        out.topRows(known) = asEigen(pca.to_basis).topRows(known).template cast<T>();
        return basis;
    }
    // 2. Otherwise combine the rows, a block of columns at a time.
    const Eigen::MatrixXd combine = asEigen(pca.to_basis).leftCols(known).transpose();
    for (Eigen::Index begin = 0; begin < m.cols(); begin += kBlock) {
        const Eigen::Index n = std::min(kBlock, m.cols() - begin);
        const Eigen::MatrixXd block = m.middleCols(begin, n).template cast<double>();
        out.block(0, begin, known, n) = (combine * block).template cast<T>();
    }
    return basis;
}

}  // namespace

Pca principalComponents(const MatrixF& rows) { return componentsOf(rows); }
Pca principalComponents(const Matrix& rows) { return componentsOf(rows); }
Matrix basisOf(const Pca& pca, const Matrix& rows, std::size_t count) { return basisRows(pca, rows, count); }
MatrixF basisOf(const Pca& pca, const MatrixF& rows, std::size_t count) { return basisRows(pca, rows, count); }

std::size_t componentsFor(const Pca& pca, double fraction) {
    std::size_t count = 0;
    for (double sum = 0; count < pca.energies.size() && sum < fraction * pca.total; ++count) sum += pca.energies[count];
    return std::max<std::size_t>(count, 1);
}

void addGram(const MatrixF& rows, Matrix& gram) {
    const Eigen::MatrixXd lower = smallerGram(rows, true);
    asEigen(gram) += Eigen::MatrixXd(lower.selfadjointView<Eigen::Lower>());
}

std::vector<double> eigenvalues(const Matrix& symmetric) {
    if (symmetric.values.empty()) return {};
    const Eigen::VectorXd values = symmetricEigenvalues(asEigen(symmetric)).reverse().cwiseMax(0.0);
    return {values.begin(), values.end()};
}

std::array<Vec3d, 3> principalAxes(std::span<const Vec3> points) {
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    for (Vec3 p : points) centroid += Eigen::Vector3d(p.x, p.y, p.z);
    centroid /= double(std::max<std::size_t>(points.size(), 1));
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (Vec3 p : points) {
        const Eigen::Vector3d d = Eigen::Vector3d(p.x, p.y, p.z) - centroid;
        scatter += d * d.transpose();
    }
    if (scatter.trace() <= 0) return {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    Eigen::MatrixXd vectors = symmetricEigenPairs(scatter).vectors.rowwise().reverse();
    fixSign(vectors);
    std::array<Vec3d, 3> axes;
    for (int k = 0; k < 3; ++k) axes[std::size_t(k)] = {vectors(0, k), vectors(1, k), vectors(2, k)};
    return axes;
}

}  // namespace penumbra
