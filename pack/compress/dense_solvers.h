#pragma once
// The decompositions of dense matrices that this stage uses. Eigen's templates for them take long to compile, so
// dense_solvers.cpp alone instantiates them.
#include <Eigen/Core>

namespace penumbra {

// a = axes diag(values) axes^T, values descending. Only the lower triangle of `a` is read.
struct SymmetricAxes {
    Eigen::VectorXd values;
    Eigen::MatrixXd axes;
};
SymmetricAxes symmetricAxes(const Eigen::MatrixXd& a);

// An orthonormal basis of the span of a's columns. A column that the others make up to `tolerance` of the longest does
// not count.
Eigen::MatrixXd orthonormalSpan(const Eigen::MatrixXd& a, double tolerance);

}  // namespace penumbra
