#pragma once
// A layer of tanh neurons, y = sum_n c^n tanh(d^n . x + d0^n) + c0: Nowrouzezahrai 2009 eq 12 with a vector for output
// and a bias for each neuron.
#include <cstddef>
#include <vector>

#include "fit/numerics/matrix.h"

namespace penumbra {

// The weights of a net with N neurons, I inputs and K outputs.
struct TanhNet {
    Matrix hidden;                    // [N, I] d^n
    std::vector<double> hidden_bias;  // [N] d0^n
    Matrix output;                    // [N, K] c^n
    std::vector<double> output_bias;  // [K] c0

    std::size_t neurons() const { return hidden.rows; }
};

// Returns a net whose weights are all zero.
TanhNet emptyNet(std::size_t inputs, std::size_t outputs, std::size_t neurons);

Matrix activations(const TanhNet& net, const Matrix& inputs);  // [F, N] tanh(d^n . x + d0^n)
Matrix predict(const TanhNet& net, const Matrix& inputs);      // [F, K]

}  // namespace penumbra
