#include "fit/models/neural_bfgs.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace penumbra {

namespace {

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
