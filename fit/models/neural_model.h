#pragma once
// A layer of tanh neurons, y = sum_n c^n tanh(d^n . x + d0^n) + c0: Nowrouzezahrai 2009 eq 12 with a vector for output
// and a bias for each neuron.
#include <cstddef>
#include <vector>

#include "fit/numerics/matrix.h"

namespace penumbra {

// The contiguous inputs that a neuron sees.
struct InputRange {
    std::size_t first = 0, count = 0;
    bool operator==(const InputRange&) const = default;
};

// The weights of a net with N neurons, I inputs and K outputs.
struct TanhNet {
    Matrix hidden;                    // [N, I] d^n, zero outside the neuron's range
    std::vector<double> hidden_bias;  // [N] d0^n
    Matrix output;                    // [N, K] c^n
    std::vector<double> output_bias;  // [K] c0
    std::vector<InputRange> ranges;   // [N]; empty when every neuron sees every input

    std::size_t neurons() const { return hidden.rows; }
    InputRange rangeOf(std::size_t n) const { return ranges.empty() ? InputRange{0, hidden.columns} : ranges[n]; }
};

// Returns a net whose weights are all zero.
TanhNet emptyNet(std::size_t inputs, std::size_t outputs, std::size_t neurons, std::vector<InputRange> ranges = {});

Matrix activations(const TanhNet& net, const Matrix& inputs);  // [F, N] tanh(d^n . x + d0^n)
Matrix predict(const TanhNet& net, const Matrix& inputs);      // [F, K]

// Returns the value of Nowrouzezahrai 2009 eq 13: sum over frames |prediction - y|^2 + alpha sum_n (|c^n|^2 + |d^n|^2).
// The biases are free.
double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha);
// Also sets `gradient` to the derivative by every weight. It is zero for weights outside a neuron's range.
double netObjective(const TanhNet& net, const Matrix& inputs, const Matrix& outputs, double alpha, TanhNet& gradient);

}  // namespace penumbra
