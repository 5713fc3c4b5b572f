#pragma once
// The decompositions of dense matrices that this stage uses. Eigen's templates for them take most of a minute to
// compile, so only dense_solvers.cpp instantiates them for matrices of any size, and other files call these functions.
#include <Eigen/Core>
#include <memory>

namespace penumbra {

using RowMajorXd = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Column k of `vectors` belongs to values[k]. Values ascend.
struct EigenPairs {
    Eigen::VectorXd values;
    Eigen::MatrixXd vectors;
};
struct EigenPairs3 {
    Eigen::Vector3d values;
    Eigen::Matrix3d vectors;
};

// Each reads the lower triangle of a symmetric matrix.
EigenPairs symmetricEigenPairs(const Eigen::MatrixXd& a);
EigenPairs3 symmetricEigenPairs(const Eigen::Matrix3d& a);
Eigen::VectorXd symmetricEigenvalues(const Eigen::MatrixXd& a);
// a v = s b v, with b positive definite and vectors^T b vectors = 1.
EigenPairs generalizedEigenPairs(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// a = u diag(sigma) v^T; sigma descends, and u and v have as many columns as sigma has values.
struct ThinSvd {
    Eigen::MatrixXd u, v;
    Eigen::VectorXd sigma;
};
ThinSvd thinSvd(const Eigen::MatrixXd& a);

// An orthonormal basis of the span of a's columns: Q of a = Q R.
Eigen::MatrixXd orthonormalColumns(const Eigen::MatrixXd& a);

// The lower L of a positive definite a = L L^T.
Eigen::MatrixXd choleskyFactor(const Eigen::MatrixXd& a);
// x of L^T x = b for a lower triangular L.
Eigen::MatrixXd solveTransposedLower(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& b);
// x of a x = b for a positive definite `a`. False, with x as it was, when `a` is not positive definite.
bool solvePositive(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
bool solvePositive(const Eigen::MatrixXd& a, const RowMajorXd& b, RowMajorXd& x);
// x of a x = b for a positive semidefinite `a`.
Eigen::Vector3d solveSemidefinite(const Eigen::Matrix3d& a, const Eigen::Vector3d& b);

constexpr int kMaxSmall = 15;  // largest number of rows and of columns
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxSmall, kMaxSmall>;
// For every column of b, the shortest x that minimises |a x - b|^2, for an `a` of any rank. A column that the others
// make up to 1e-9 of the longest does not count.
SmallMatrix solveMinNorm(const SmallMatrix& a, const SmallMatrix& b);

// Solves several a x = b for one positive semidefinite `a`: P^T L D L^T P with pivots.
class SemidefiniteSolver {
public:
    explicit SemidefiniteSolver(const Eigen::MatrixXd& a);
    ~SemidefiniteSolver();
    SemidefiniteSolver(const SemidefiniteSolver&) = delete;
    SemidefiniteSolver& operator=(const SemidefiniteSolver&) = delete;

    Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
    RowMajorXd solve(const RowMajorXd& b) const;

private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

// Makes Eigen divide products of matrices as for one size of caches. Left alone it asks the processor, and then the
// order of sums, and with it the last bits of results, depends on the machine. Call it before any other thread starts.
void useFixedBlocks();

}  // namespace penumbra
