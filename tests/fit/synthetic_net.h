#pragma once
// Makes networks and inputs for the tests of the neural fit.
#include <cmath>
#include <random>

#include "fit/models/neural_model.h"

namespace penumbra::synthetic {

// Standard normal numbers that are the same with every standard library.
class Normal {
public:
    explicit Normal(std::uint64_t seed) : random_(seed) {}
    double operator()() {
        double sum = -6;  // the sum of 12 uniform numbers has a variance of 1
        for (int i = 0; i < 12; ++i) sum += double(random_() >> 11) * 0x1p-53;
        return sum;
    }

private:
    std::mt19937_64 random_;
};

inline Matrix normalMatrix(std::size_t rows, std::size_t columns, std::uint64_t seed) {
    Normal normal(seed);
    Matrix m(rows, columns);
    for (double& x : m.values) x = normal();
    return m;
}

inline TanhNet normalNet(std::size_t inputs, std::size_t outputs, std::size_t neurons, std::uint64_t seed) {
    Normal normal(seed);
    TanhNet net = emptyNet(inputs, outputs, neurons);
    for (double& x : net.hidden.values) x = normal();
    for (double& x : net.hidden_bias) x = normal();
    for (double& x : net.output.values) x = normal();
    for (double& x : net.output_bias) x = normal();
    return net;
}

}  // namespace penumbra::synthetic
