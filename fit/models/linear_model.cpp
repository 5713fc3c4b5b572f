#include "fit/models/linear_model.h"

#include <cassert>
#include <cmath>

#include "fit/numerics/dense_solvers.h"
#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

// Both functions below compute the weights and the diagonal of the hat matrix. They agree because (X^T X + a)^-1 X^T =
// X^T (X X^T + a)^-1; each solves a system of the size of one side of X.
void solveThroughColumns(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double penalty, Eigen::MatrixXd& weights,
                         Eigen::VectorXd& hat) {
    Eigen::MatrixXd normal = x.transpose() * x;
    normal.diagonal().array() += penalty;
    const SemidefiniteSolver solver(normal);
    weights = solver.solve(Eigen::MatrixXd(x.transpose() * y));
    hat = x.cwiseProduct(solver.solve(RowMajorXd(x.transpose())).transpose()).rowwise().sum();
}

void solveThroughRows(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double penalty, Eigen::MatrixXd& weights,
                      Eigen::VectorXd& hat) {
    const Eigen::MatrixXd gram = x * x.transpose();
    Eigen::MatrixXd normal = gram;
    normal.diagonal().array() += penalty;
    const SemidefiniteSolver solver(normal);
    weights = x.transpose() * solver.solve(y);
    hat = solver.solve(gram).diagonal();
}

}  // namespace

Ridge fitRidge(const Matrix& inputs, const Matrix& outputs, double alpha) {
    assert(inputs.rows == outputs.rows && inputs.rows > 0);
    // 1. Take the means off both sides.
    const Eigen::RowVectorXd x_mean = asEigen(inputs).colwise().mean(), y_mean = asEigen(outputs).colwise().mean();
    const Eigen::MatrixXd x = asEigen(inputs).rowwise() - x_mean, y = asEigen(outputs).rowwise() - y_mean;
    // 2. Solve through the smaller side.
    Eigen::MatrixXd weights;
    Eigen::VectorXd hat;
    (x.rows() < x.cols() ? solveThroughRows : solveThroughColumns)(x, y, alpha * alpha, weights, hat);

    // 3. Put the means back as the intercept, and add its share to the leverages.
    Ridge ridge;
    ridge.weights = Matrix(inputs.columns, outputs.columns);
    asEigen(ridge.weights) = weights;
    const Eigen::RowVectorXd intercept = y_mean - x_mean * weights;
    ridge.intercept.assign(intercept.data(), intercept.data() + intercept.size());
    for (double h : hat) ridge.leverage.push_back(h + 1.0 / double(inputs.rows));
    return ridge;
}

Matrix predict(const Ridge& ridge, const Matrix& inputs) {
    Matrix out(inputs.rows, ridge.weights.columns);
    asEigen(out) = asEigen(inputs) * asEigen(ridge.weights);
    for (std::size_t r = 0; r < out.rows; ++r)
        for (std::size_t k = 0; k < out.columns; ++k) out(r, k) += ridge.intercept[k];
    return out;
}

double leaveOneOutError(const Ridge& ridge, const Matrix& inputs, const Matrix& outputs) {
    const Matrix predicted = predict(ridge, inputs);
    double sum = 0;
    for (std::size_t r = 0; r < outputs.rows; ++r)
        for (std::size_t k = 0; k < outputs.columns; ++k) {
            const double residual = (outputs(r, k) - predicted(r, k)) / (1 - ridge.leverage[r]);
            sum += residual * residual;
        }
    return std::sqrt(sum / double(outputs.values.size()));
}

}  // namespace penumbra
