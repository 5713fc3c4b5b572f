#pragma once
// The fast optimiser of a tanh net (Nowrouzezahrai 2009 eq 13) by variable projection (Golub and Pereyra 1973). For
// given hidden weights the best output weights are a ridge regression, so only the hidden weights are searched. The
// .cpp file and docs/formulas.md, section 4, explain the method; tests/fit/neural_bfgs.h is the reference.
#include <cstddef>
#include <vector>

#include "fit/models/neural_model.h"
#include "fit/numerics/quasi_newton.h"

namespace penumbra {

// Inputs and centered outputs, one row per input or output and one column per frame (net_kernels.h). Rows are padded
// with zeros to `stride`. One NetData serves many fits.
struct NetData {
    std::size_t frames = 0, stride = 0, inputs = 0, outputs = 0;
    std::vector<double> x, x_squared;  // [I, stride], and the squares of its entries
    std::vector<double> y;             // [K, stride]
    std::vector<double> y_mean;        // [K] what was taken off the outputs
};
NetData netData(const Matrix& inputs, const Matrix& outputs);

struct NetFit {
    TanhNet net;
    double objective = 0;  // the value of eq 13
    int iterations = 0, evaluations = 0;
};

// Minimises eq 13 from the hidden weights and biases of `start`. The output weights of `start` are not read.
// alpha must be positive.
NetFit fitByProjection(const NetData& data, const TanhNet& start, double alpha, const SearchOptions& options);

}  // namespace penumbra
