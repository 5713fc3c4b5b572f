#include "tests/fit/neural_bfgs.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fit/numerics/eigen_map.h"

namespace penumbra {

namespace {

double penalty(const TanhNet& net) { return asEigen(net.hidden).squaredNorm() + asEigen(net.output).squaredNorm(); }

// Calls visit() with every array of weights, always in the same order.
template <class Net, class Visit>
void visitWeights(Net& net, Visit visit) {
    visit(net.hidden.values), visit(net.hidden_bias), visit(net.output.values), visit(net.output_bias);
}

std::vector<double> weightsOf(const TanhNet& net) {
    std::vector<double> all;
    visitWeights(net, [&](const std::vector<double>& part) { all.insert(all.end(), part.begin(), part.end()); });
    return all;
}

void setWeights(TanhNet& net, const double* weights) {
    visitWeights(net, [&](std::vector<double>& part) {
        std::copy_n(weights, part.size(), part.begin());
        weights += part.size();
    });
}

}  // namespace

double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha) {
    return (asEigen(predict(net, inputs)) - asEigen(outputs)).squaredNorm() + alpha * penalty(net);
}

double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha, TanhNet& gradient) {
    const Matrix h = activations(net, inputs);
    // 1. Forward: activations and residuals.
    EigenRows<double> residual = asEigen(h) * asEigen(net.output) - asEigen(outputs);
    residual.rowwise() += Eigen::Map<const Eigen::RowVectorXd>(net.output_bias.data(), residual.cols());
    // 2. Derivative by each neuron's argument, taken back through the output weights and tanh.
    const EigenRows<double> slope =
        (2 * residual * asEigen(net.output).transpose()).cwiseProduct((1 - asEigen(h).array().square()).matrix());

    gradient = emptyNet(net.hidden.columns, net.output.columns, net.neurons());
    // 3. Derivatives by the weights, each with its part of the penalty, then by the biases.
    asEigen(gradient.output) = 2 * (asEigen(h).transpose() * residual + alpha * asEigen(net.output));
    asEigen(gradient.hidden) = slope.transpose() * asEigen(inputs) + 2 * alpha * asEigen(net.hidden);
    Eigen::Map<Eigen::RowVectorXd>(gradient.hidden_bias.data(), slope.cols()) = slope.colwise().sum();
    Eigen::Map<Eigen::RowVectorXd>(gradient.output_bias.data(), residual.cols()) = 2 * residual.colwise().sum();
    return residual.squaredNorm() + alpha * penalty(net);
}

NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                 const SearchOptions& options) {
    NetFit fit{start};
    std::vector<double> weights = weightsOf(start);
    const SearchResult found = minimise(
        [&](std::span<const double> at, std::span<double> gradient) {
            TanhNet slope;
            setWeights(fit.net, at.data());
            const double objective = netObjective(fit.net, inputs, outputs, alpha, slope);
            const std::vector<double> values = weightsOf(slope);
            std::copy(values.begin(), values.end(), gradient.begin());
            return objective;
        },
        options, weights);
    if (!std::isfinite(found.value)) throw std::runtime_error("BFGS: the objective is not finite at the start");
    setWeights(fit.net, weights.data());
    fit.objective = netObjective(fit.net, inputs, outputs, alpha);
    fit.iterations = found.iterations;
    fit.evaluations = found.evaluations;
    return fit;
}

}  // namespace penumbra
