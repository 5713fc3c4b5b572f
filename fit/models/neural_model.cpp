#include "fit/models/neural_model.h"

#include <cassert>
#include <cmath>

#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

using RowVector = Eigen::Map<const Eigen::RowVectorXd>;

RowVector asRow(const std::vector<double>& v) { return {v.data(), Eigen::Index(v.size())}; }

void clearOutsideRange(const TanhNet& net, Matrix& hidden) {
    for (std::size_t n = 0; n < net.neurons(); ++n) {
        const InputRange range = net.rangeOf(n);
        for (std::size_t i = 0; i < hidden.columns; ++i)
            if (i < range.first || i >= range.first + range.count) hidden(n, i) = 0;
    }
}

double penalty(const TanhNet& net) { return asEigen(net.hidden).squaredNorm() + asEigen(net.output).squaredNorm(); }

}  // namespace

TanhNet emptyNet(std::size_t inputs, std::size_t outputs, std::size_t neurons, std::vector<InputRange> ranges) {
    assert(ranges.empty() || ranges.size() == neurons);
    TanhNet net;
    net.hidden = Matrix(neurons, inputs);
    net.hidden_bias.resize(neurons);
    net.output = Matrix(neurons, outputs);
    net.output_bias.resize(outputs);
    net.ranges = std::move(ranges);
    return net;
}

Matrix activations(const TanhNet& net, const Matrix& inputs) {
    Matrix h(inputs.rows, net.neurons());
    asEigen(h).noalias() = asEigen(inputs) * asEigen(net.hidden).transpose();
    asEigen(h).rowwise() += asRow(net.hidden_bias);
    for (double& x : h.values) x = std::tanh(x);
    return h;
}

Matrix predict(const TanhNet& net, const Matrix& inputs) {
    Matrix out(inputs.rows, net.output.columns);
    asEigen(out).noalias() = asEigen(activations(net, inputs)) * asEigen(net.output);
    asEigen(out).rowwise() += asRow(net.output_bias);
    return out;
}

double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha) {
    return (asEigen(predict(net, inputs)) - asEigen(outputs)).squaredNorm() + alpha * penalty(net);
}

double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha, TanhNet& gradient) {
    const Matrix h = activations(net, inputs);
    // 1. Forward: activations and residuals.
    EigenRows<double> residual = asEigen(h) * asEigen(net.output) - asEigen(outputs);
    residual.rowwise() += asRow(net.output_bias);
    // 2. Derivative by each neuron's argument, taken back through the output weights and tanh.
    const EigenRows<double> slope =
        (2 * residual * asEigen(net.output).transpose()).cwiseProduct((1 - asEigen(h).array().square()).matrix());

    gradient = emptyNet(net.hidden.columns, net.output.columns, net.neurons(), net.ranges);
    // 3. Derivatives by the weights, each with its part of the penalty, then by the biases.
    asEigen(gradient.output) = 2 * (asEigen(h).transpose() * residual + alpha * asEigen(net.output));
    asEigen(gradient.hidden) = slope.transpose() * asEigen(inputs) + 2 * alpha * asEigen(net.hidden);
    clearOutsideRange(net, gradient.hidden);
    Eigen::Map<Eigen::RowVectorXd>(gradient.hidden_bias.data(), slope.cols()) = slope.colwise().sum();
    Eigen::Map<Eigen::RowVectorXd>(gradient.output_bias.data(), residual.cols()) = 2 * residual.colwise().sum();
    return residual.squaredNorm() + alpha * penalty(net);
}

}  // namespace penumbra
