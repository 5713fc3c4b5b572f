#include "fit/models/neural_model.h"

#include <cmath>

#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

using RowVector = Eigen::Map<const Eigen::RowVectorXd>;

RowVector asRow(const std::vector<double>& v) { return {v.data(), Eigen::Index(v.size())}; }

}  // namespace

TanhNet emptyNet(std::size_t inputs, std::size_t outputs, std::size_t neurons) {
    TanhNet net;
    net.hidden = Matrix(neurons, inputs);
    net.hidden_bias.resize(neurons);
    net.output = Matrix(neurons, outputs);
    net.output_bias.resize(outputs);
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

}  // namespace penumbra
