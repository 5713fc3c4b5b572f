#pragma once
// The papers' optimiser of Nowrouzezahrai 2009 eq 13: BFGS or L-BFGS over all weights at once, through Ceres. It is the
// reference for the fast optimiser (fit/models/variable_projection.h).
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fit/models/variable_projection.h"

namespace penumbra {

// 5000 iterations: Nowrouzezahrai 2009, section 5.3.
constexpr SearchOptions kPapersSearch{
    .method = QuasiNewton::kBfgs, .iterations = 5000, .least_decrease = 1e-10, .window = 1};

// Calls visit() with every array of weights, always in the same order.
template <class Net, class Visit>
void visitWeights(Net& net, Visit visit) {
    visit(net.hidden.values), visit(net.hidden_bias), visit(net.output.values), visit(net.output_bias);
}

inline std::vector<double> weightsOf(const TanhNet& net) {
    std::vector<double> all;
    visitWeights(net, [&](const std::vector<double>& part) { all.insert(all.end(), part.begin(), part.end()); });
    return all;
}

inline void setWeights(TanhNet& net, const double* weights) {
    visitWeights(net, [&](std::vector<double>& part) {
        std::copy_n(weights, part.size(), part.begin());
        weights += part.size();
    });
}

// Minimises eq 13 from all weights of `start`. Weights outside a neuron's range stay zero. Throws std::runtime_error
// when the objective is not finite at the start.
inline NetFit fitByBfgs(const Matrix& inputs, const Matrix& outputs, const TanhNet& start, double alpha,
                        const SearchOptions& options = kPapersSearch) {
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
