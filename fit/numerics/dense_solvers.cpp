#include "fit/numerics/dense_solvers.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace penumbra {

namespace {

template <class Rows>
bool solvedByCholesky(const Eigen::MatrixXd& a, const Rows& b, Rows& x) {
    const Eigen::LLT<Eigen::MatrixXd> solver(a);
    if (solver.info() != Eigen::Success) return false;
    x = solver.solve(b).eval();
    return true;
}

}  // namespace

void useFixedBlocks() { Eigen::setCpuCacheSizes(48 << 10, 2 << 20, 32 << 20); }

EigenPairs symmetricEigenPairs(const Eigen::MatrixXd& a) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

EigenPairs3 symmetricEigenPairs(const Eigen::Matrix3d& a) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetricEigenvalues(const Eigen::MatrixXd& a) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

EigenPairs generalizedEigenPairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(a, b);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

ThinSvd thinSvd(const Eigen::MatrixXd& a) {
    const Eigen::BDCSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

Eigen::MatrixXd orthonormalColumns(const Eigen::MatrixXd& a) {
    return Eigen::HouseholderQR<Eigen::MatrixXd>(a).householderQ() * Eigen::MatrixXd::Identity(a.rows(), a.cols());
}

Eigen::MatrixXd choleskyFactor(const Eigen::MatrixXd& a) { return a.llt().matrixL(); }

Eigen::MatrixXd solveTransposedLower(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& b) {
    return lower.triangularView<Eigen::Lower>().transpose().solve(b);
}

bool solvePositive(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
    return solvedByCholesky(a, b, x);
}
bool solvePositive(const Eigen::MatrixXd& a, const RowMajorXd& b, RowMajorXd& x) { return solvedByCholesky(a, b, x); }

Eigen::Vector3d solveSemidefinite(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) { return a.ldlt().solve(b); }

SmallMatrix solveMinNorm(const SmallMatrix& a, const SmallMatrix& b) {
    Eigen::CompleteOrthogonalDecomposition<SmallMatrix> solver;
    solver.setThreshold(1e-9);
    solver.compute(a);
    return solver.solve(b);
}

struct SemidefiniteSolver::Factor {
    Eigen::LDLT<Eigen::MatrixXd> ldlt;
};

SemidefiniteSolver::SemidefiniteSolver(const Eigen::MatrixXd& a)
    : factor_(std::make_unique<Factor>(Factor{Eigen::LDLT<Eigen::MatrixXd>(a)})) {}
SemidefiniteSolver::~SemidefiniteSolver() = default;
Eigen::MatrixXd SemidefiniteSolver::solve(const Eigen::MatrixXd& b) const { return factor_->ldlt.solve(b); }
RowMajorXd SemidefiniteSolver::solve(const RowMajorXd& b) const { return factor_->ldlt.solve(b); }

}  // namespace penumbra
