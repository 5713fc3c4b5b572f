#include "pack/compress/dense_solvers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace penumbra {

SymmetricAxes symmetricAxes(const Eigen::MatrixXd& a) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);  // its values ascend
    return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse()};
}

Eigen::MatrixXd orthonormalSpan(const Eigen::MatrixXd& a, double tolerance) {
    if (a.size() == 0) return {a.rows(), 0};
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
    qr.setThreshold(tolerance);
    return qr.householderQ() * Eigen::MatrixXd::Identity(a.rows(), qr.rank());
}

}  // namespace penumbra
