#pragma once
// The fast optimiser of eq 13. For given hidden weights the best output weights are a ridge regression, so only the
// hidden weights are searched: variable projection (Golub and Pereyra 1973). The projected objective has the gradient
// of eq 13 with the output weights held at their best; L-BFGS with the Gauss-Newton diagonal minimises it.
#include <cstddef>
#include <vector>

#include "fit/models/neural_model.h"
#include "fit/numerics/lbfgs.h"

namespace penumbra {

// Inputs and centred outputs as rows along the frames (net_kernels.h); made once for many fits.
struct NetData {
    std::size_t frames = 0, stride = 0, inputs = 0, outputs = 0;
    std::vector<double> x, x_squared;  // [I, stride]
    std::vector<double> y;             // [K, stride]
    std::vector<double> y_mean;        // [K]
};
NetData netData(const Matrix& inputs, const Matrix& outputs);

struct NetFit {
    TanhNet net;
    double objective = 0;  // eq 13
    int iterations = 0, evaluations = 0;
};

// Starts at the hidden weights, biases and ranges of `start`; its output weights are not read. alpha > 0.
NetFit fitByProjection(const NetData& data, const TanhNet& start, double alpha, const LbfgsOptions& options);

}  // namespace penumbra
