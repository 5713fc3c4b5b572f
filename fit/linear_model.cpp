#include "fit/linear_model.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>

#include "fit/eigen_map.h"

namespace penumbra {

Ridge fitRidge(const Matrix& inputs, const Matrix& outputs, double alpha) {
    assert(inputs.rows == outputs.rows && inputs.rows > 0);
    const Eigen::RowVectorXd x_mean = asEigen(inputs).colwise().mean(), y_mean = asEigen(outputs).colwise().mean();
    const Eigen::MatrixXd x = asEigen(inputs).rowwise() - x_mean;
    Eigen::MatrixXd normal = x.transpose() * x;
    normal.diagonal().array() += alpha * alpha;
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);

    Ridge ridge;
    ridge.weights = Matrix(inputs.columns, outputs.columns);
    auto weights = asEigen(ridge.weights);
    weights = solver.solve(x.transpose() * (asEigen(outputs).rowwise() - y_mean));
    const Eigen::RowVectorXd intercept = y_mean - x_mean * weights;
    ridge.intercept.assign(intercept.data(), intercept.data() + intercept.size());
    const Eigen::VectorXd hat = x.cwiseProduct(solver.solve(x.transpose()).transpose()).rowwise().sum();
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
